from mrsfi_runtime.causes.chain import Robustness, robustness


def test_it_is_median_range_and_in_how_many_seeds_a_goal_is_violated():
    by_seed = [(0, 5), (0, 1), (7, 3), (9, 2)]

    assert robustness(by_seed) == (Robustness(3.5, 0, 9, 2), Robustness(2.5, 1, 5, 4))
