//! Which joints of a topic stand in the same messages: several programs may publish on one topic, each some of the joints.

use tunenet_formats::Contents;

use super::columns::Columns;

/// Those whose positions stand in one message, the most that do, and the others.
pub fn in_one_message(all: Vec<Columns>, contents: &Contents) -> (Vec<Columns>, Vec<Columns>) {
    let topic = all.first().and_then(|columns| columns.state.topic.clone());
    let (Some(topic), Contents::Log(log)) = (topic, contents) else { return (all, Vec::new()) };
    let of_topic = log.topics.iter().filter(|one| one.name == topic).flat_map(|one| &one.layouts);
    let within = |layout: &Vec<String>| all.iter().filter(|one| layout.contains(&one.state.column)).count();
    // The first of several that have as many.
    let Some(layout) = of_topic.rev().max_by_key(|layout| within(layout)).filter(|layout| within(layout) > 0) else {
        return (all, Vec::new());
    };
    let layout = layout.clone();
    all.into_iter().partition(|one| layout.contains(&one.state.column))
}
