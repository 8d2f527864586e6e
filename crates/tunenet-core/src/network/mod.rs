//! What has been learned: the two-branch network, its data, its training.
