"""A team's own collective intelligence: what it is told, how it commands, when it has answered."""
