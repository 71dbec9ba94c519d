"""What active faults do: a module for each thing that they act on."""
