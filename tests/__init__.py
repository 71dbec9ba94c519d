"""Tests of the whole, by rooms, and in ``support`` what several rooms share."""
