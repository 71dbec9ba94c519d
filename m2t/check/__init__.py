"""Check nodes against the metamodel: structure, values, references, parts in other files."""
