from mrsfi_runtime.causes.findings import findings
from mrsfi_runtime.model.faults import TimedFault


def cause(*faults):
    return tuple(TimedFault(*fault) for fault in faults)


def test_the_same_faults_in_windows_that_overlap_are_one_finding_whatever_their_values():
    first = cause(("f1", 10, 20, (1.0,)), ("f2", 50, 60))
    second = cause(("f2", 60, 70), ("f1", 0, 10, (9.0,)))

    assert findings([first, second]) == ((0, 1),)


def test_one_window_that_does_not_overlap_makes_another_finding():
    first = cause(("f1", 10, 20), ("f2", 50, 60))
    second = cause(("f1", 10, 20), ("f2", 61, 70))

    assert findings([first, second]) == ((0,), (1,))


def test_one_fault_more_or_another_one_makes_another_finding():
    first = cause(("f1", 10, 20))

    assert findings([first, (*first, TimedFault("f2", 0, 9)), cause(("f3", 10, 20))]) == (
        (0,),
        (1,),
        (2,),
    )


def test_several_of_one_fault_are_held_against_each_other_by_time():
    first = cause(("f1", 10, 20), ("f1", 50, 60))
    second = cause(("f1", 55, 70), ("f1", 15, 17))

    assert findings([first, second]) == ((0, 1),)


def test_whoever_joins_is_like_the_leader_not_only_like_another_member():
    chain = [cause(("f1", 10, 20)), cause(("f1", 20, 30)), cause(("f1", 30, 40))]

    assert findings(chain) == ((0, 1), (2,))


def test_no_cause_set_is_no_finding():
    assert findings([]) == ()
