"""What a run leaves behind: the campaign store and the trace."""
