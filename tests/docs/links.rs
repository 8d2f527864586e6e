//! Every link in README and docs leads somewhere: to a file that is there, and to a heading in it.

use crate::docs::page::{Page, pages, root, text};

#[test]
fn every_link_leads_somewhere() {
    let (all, mut count) = (pages(), 0);
    let at = |name: &str| -> Option<&Page> { all.iter().find(|p| p.name == name) };
    for page in &all {
        for link in page.links() {
            if link.contains("://") {
                continue;
            }
            let (file, anchor) =
                link.split_once('#').map_or((link.as_str(), None), |(file, anchor)| (file, Some(anchor)));
            let folder = page.name.rsplit_once('/').map_or("", |(folder, _)| folder);
            let target = if file.is_empty() { page.name.clone() } else { joined(folder, file) };
            assert!(root().join(&target).exists(), "{} links to {link}, which is not there", page.name);
            if let Some(anchor) = anchor {
                let known = at(&target).unwrap_or_else(|| panic!("{}: {link}: no page", page.name)).anchors();
                assert!(known.iter().any(|a| a == anchor), "{}: {link}: {target} has only {known:?}", page.name);
            }
            // The book holds docs/ alone.
            assert!(folder != "docs" || target.starts_with("docs/"), "{}: {link} leads out of the book", page.name);
            count += 1;
        }
    }
    assert!(count > 60, "only {count} links found");
}

/// `file` as seen from `folder`.
fn joined(folder: &str, file: &str) -> String {
    let mut parts: Vec<&str> = folder.split('/').filter(|p| !p.is_empty()).collect();
    for part in file.split('/') {
        match part {
            ".." => {
                parts.pop();
            }
            "." => {}
            part => parts.push(part),
        }
    }
    parts.join("/")
}

#[test]
fn every_page_is_a_chapter_of_the_book() {
    let all = pages();
    let summary = all.iter().find(|p| p.name == "docs/SUMMARY.md").unwrap();
    let chapters = summary.links();
    for page in all.iter().filter(|p| p.name.starts_with("docs/") && p.name != summary.name) {
        let name = page.name.trim_start_matches("docs/");
        assert_eq!(chapters.iter().filter(|c| *c == name).count(), 1, "docs/SUMMARY.md: {name}");
        assert!(page.text.starts_with("# "), "{name} begins with its title");
    }
}

#[test]
fn the_page_on_embedding_shows_the_example_that_is_tested() {
    let page = text("docs/embedding.md");
    let example = text("crates/tunenet-core/examples/pendulum.rs");
    assert!(page.contains(&format!("```rust\n{example}```\n")), "docs/embedding.md shows another pendulum.rs");
    let cart = text("crates/tunenet-core/examples/driven_cart.rs");
    assert!(page.contains(&format!("```rust\n{cart}```\n")), "docs/embedding.md shows another driven_cart.rs");
}
