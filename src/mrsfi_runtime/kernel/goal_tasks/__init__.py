"""What robots may have to achieve: a module per goal task.

Each has the task's record, and kernel functions of a goal's index: ``violated`` tells whether
the goal is violated in a state, ``react`` commands its members, and ``progress``, where there is
one, notes once a tick what the other two have to remember.

References
----------
Source paper, sections III-B a) and III-G (``checkRequirements``). The paper leaves the reactions
to the user; what stands here is described in ``docs/semantics.md``.
"""
