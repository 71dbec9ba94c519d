"""Command line: the composition root, one module per subcommand."""
