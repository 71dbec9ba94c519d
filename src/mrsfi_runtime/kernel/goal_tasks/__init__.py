"""The goal tasks, one module each.

Each module has the task's record, and kernel functions of a goal's index. ``violated`` returns
whether the goal is violated in a state. ``react`` commands its members. ``progress``, if present,
records once a tick what the other two need later.

References
----------
Source paper, sections III-B a) and III-G (``checkRequirements``). The paper leaves the reactions
to the user; ``docs/semantics.md`` describes these.
"""
