//! Training data in, comparisons of learners out: the study of the four nets, and what lies beyond them.
