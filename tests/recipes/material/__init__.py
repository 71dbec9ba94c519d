"""Files that recipes add to a copy of the tree, as a team would write them."""
