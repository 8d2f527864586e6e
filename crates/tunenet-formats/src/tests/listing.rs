//! What `contents` says.

use crate::testing::{bag, ball, file, made};
use crate::{BrokenLine, Contents, contents};
use tunenet_core::observation::Kind;

#[test]
fn a_table_is_listed_with_its_broken_lines() {
    let (_folder, path) = file("a.csv", "t_s,z_m,note\n0,1,a\n0.1,x,b\n0.1,2,c\n0.2,3,d\n0.5,4,e\n0.4,5,f\n");
    let Contents::Table(table) = contents(&path).unwrap() else { panic!("a table") };
    assert_eq!(
        table.columns.iter().map(|c| c.read_as.as_deref()).collect::<Vec<_>>(),
        [Some("t_s"), Some("z_m"), None]
    );
    assert_eq!((table.rows, table.samples, table.span_s), (6, 4, Some((0.0, 0.5))));
    assert_eq!(table.median_rate_hz, Some(10.0));
    assert!((table.largest_gap_s.unwrap() - 0.3).abs() < 1e-12);
    assert_eq!(table.broken_count, 2);
    let message = "the time falls: expected more than 0.5, found 0.4".into();
    assert_eq!(table.broken[1], BrokenLine { line: 7, message });
    assert_eq!(table.usable, Err("line 3: `z_m`: expected a number, found `x`".into()));
}

#[test]
fn at_most_ten_broken_lines_are_kept() {
    let (_folder, path) = file("a.csv", format!("t_s,z_m\n{}", "0,x\n".repeat(25)));
    let Contents::Table(table) = contents(&path).unwrap() else { panic!("a table") };
    assert_eq!((table.broken.len(), table.broken_count), (10, 25));
    let hint = crate::read(&path, &crate::ReadOptions::default()).unwrap_err();
    assert!(
        hint.hint().unwrap().ends_with("; also lines 3, 4, 5, 6, 7, 8, 9, 10, 11 and 15 more"),
        "{:?}",
        hint.hint()
    );
}

#[test]
fn a_table_without_a_known_header_is_listed_too() {
    let (_folder, path) = file("a.csv", "time,b\n0,1\n1,1\n");
    let Contents::Table(table) = contents(&path).unwrap() else { panic!("a table") };
    assert_eq!((table.columns[1].name.as_str(), table.rows, table.samples), ("b", 2, 0));
    assert!(table.usable.unwrap_err().ends_with("found `time`, `b`"));
    assert!(table.remedy.starts_with("say which column is which"), "{}", table.remedy);
}

#[test]
fn topics_are_listed_with_their_use() {
    let chatter = made("/chatter", "std_msgs/msg/String", 5, |_, _| vec![0; 8]);
    let whole = bag(None, &[chatter, ball(300)]);
    let (_folder, path) = file("a.mcap", &whole);
    let Contents::Log(log) = contents(&path).unwrap() else { panic!("a log") };
    assert_eq!(log.ended, None);
    let listed: Vec<_> = log.topics.iter().map(|t| (t.name.as_str(), t.messages, t.usable.clone())).collect();
    let why = "carries no positions, joints or bounces".to_owned();
    assert_eq!(listed, [("/ball/point", 300, Ok(Kind::Positions)), ("/chatter", 5, Err(why))]);
    let (_folder, path) = file("a.mcap", &whole[..whole.len() / 3]);
    let Contents::Log(log) = contents(&path).unwrap() else { panic!("a log") };
    let read: u64 = log.topics.iter().map(|topic| topic.messages).sum();
    assert_eq!(log.ended, Some(format!("the recording is cut off: {read} messages could be read before")));
}
