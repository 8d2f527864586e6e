//! Names that end in a number, as those of episodes and of the parts of a recording do.

/// What stands before the number of an episode in its name, where a data set numbers its episodes itself.
pub(crate) const EPISODE: &str = "episode_";

/// A name without the digits that it ends in, and their number: `demo_12` is `demo_` and 12.
pub(crate) fn split(name: &str) -> (&str, Option<u64>) {
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
    (stem, name[stem.len()..].parse().ok())
}

/// The number of an episode by the name that it has behind its data set: `episode_3`.
pub(crate) fn of_episode(name: &str) -> Option<u64> {
    let (stem, number) = split(name);
    number.filter(|_| stem == EPISODE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_at_the_end_counts() {
        assert_eq!(split("demo_012"), ("demo_", Some(12)));
        assert_eq!(split("7"), ("", Some(7)));
        assert_eq!(split("demo"), ("demo", None));
        assert_eq!(split("demo_99999999999999999999"), ("demo_", None));
        assert_eq!(of_episode("episode_3"), Some(3));
        assert_eq!((of_episode("episode_3.csv"), of_episode("episode_"), of_episode("demo_3")), (None, None, None));
    }
}
