"""One visitor per generated file."""
