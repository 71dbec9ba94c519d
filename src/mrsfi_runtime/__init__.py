"""Runtime of mrsfi: hosts generated missions, injects faults, evolves fault specifications."""
