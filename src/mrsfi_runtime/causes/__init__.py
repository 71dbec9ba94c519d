"""Why a specification breaks goals: which of its faults did it, and how."""
