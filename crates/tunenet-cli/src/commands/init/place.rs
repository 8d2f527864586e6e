//! Where in a recording a column stands.

use tunenet_core::observation::plain;
use tunenet_formats::{JointQuantity, NamedColumn};

/// A column, and the topic of a log that it stands in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    pub column: String,
    pub topic: Option<String>,
}

impl Place {
    pub fn of(column: &NamedColumn) -> Self {
        Self { column: column.name.clone(), topic: column.topic.clone() }
    }

    /// In words: `position.elbow of /joint_states`.
    pub fn described(&self) -> String {
        self.topic.as_ref().map_or_else(|| self.column.clone(), |topic| format!("{} of {topic}", self.column))
    }

    /// What `--joints` names: a column, `/topic`, or `/topic:column`. Of a topic alone, it is the joint's column, or the only one.
    pub fn parse(text: &str, found: &[NamedColumn], joint: &str) -> Self {
        let Some((topic, column)) = topic_and_column(text) else {
            let topic = found.iter().find(|column| column.name == text).and_then(|column| column.topic.clone());
            return Self { column: text.to_owned(), topic };
        };
        let within = || found.iter().filter(|column| column.topic.as_deref() == Some(topic));
        let own = || within().find(|column| column.of_joint(joint).is_some()).or_else(|| within().next());
        let column = column.map(str::to_owned).or_else(|| own().map(|column| column.name.clone()));
        Self { column: column.unwrap_or_default(), topic: Some(topic.to_owned()) }
    }

    /// Whether a recording has what such a text names.
    pub fn is_in(text: &str, found: &[NamedColumn]) -> bool {
        match topic_and_column(text) {
            Some((topic, column)) => found
                .iter()
                .any(|known| known.topic.as_deref() == Some(topic) && column.is_none_or(|column| known.name == column)),
            None => found.iter().any(|known| known.name == text),
        }
    }
}

fn topic_and_column(text: &str) -> Option<(&str, Option<&str>)> {
    let text = text.strip_prefix('/').map(|_| text)?;
    Some(text.split_once(':').map_or((text, None), |(topic, column)| (topic, Some(column))))
}

/// The column of a joint's positions: one whose name is the joint's, or the only one that says so in other words.
pub fn position<'a>(joint: &str, columns: &(impl Iterator<Item = &'a NamedColumn> + Clone)) -> Option<&'a NamedColumn> {
    let own = columns.clone().find(|column| plain(&column.name) == plain(joint));
    let of = |quantity: Option<JointQuantity>| {
        let is = move |column: &&NamedColumn| {
            column.of_joint(joint).is_some_and(|of| !of.command && of.quantity == quantity)
        };
        let mut all = columns.clone().filter(is);
        all.next().filter(|_| all.next().is_none())
    };
    own.or_else(|| of(Some(JointQuantity::Position))).or_else(|| of(None))
}
