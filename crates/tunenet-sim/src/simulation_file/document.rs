//! The TOML document behind a simulation file: read and changed by path, with its comments and its order kept.

use std::fmt;

use toml_edit::{DocumentMut, Item, Table};

/// A parsed document. Two are equal where their texts are.
#[derive(Debug, Clone)]
pub(super) struct Document(DocumentMut);

impl PartialEq for Document {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_string() == other.0.to_string()
    }
}

impl fmt::Display for Document {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(to)
    }
}

impl Document {
    pub fn new(document: DocumentMut) -> Self {
        Self(document)
    }

    /// As the deserializer of the scene takes it.
    pub fn to_deserialize(&self) -> DocumentMut {
        self.0.clone()
    }

    pub fn root(&self) -> &Table {
        self.0.as_table()
    }

    pub fn root_mut(&mut self) -> &mut Table {
        self.0.as_table_mut()
    }

    /// The item at `path` (`table.key`), where there is one.
    pub fn item(&self, path: &str) -> Option<&Item> {
        let mut item = self.0.as_item();
        for part in path.split('.') {
            item = item.as_table_like()?.get(part)?;
        }
        Some(item)
    }

    /// Changes the text at `path`, where there is one; all that stands around it is kept.
    pub fn set_text(&mut self, path: &str, text: &str) {
        let mut item = Some(self.0.as_item_mut());
        for part in path.split('.') {
            item = item.and_then(|item| item.as_table_like_mut()?.get_mut(part));
        }
        if let Some(value) = item.and_then(Item::as_value_mut) {
            let decor = value.decor().clone();
            *value = text.into();
            *value.decor_mut() = decor;
        }
    }

    /// Removes the key at `path`; a key of the root stays.
    pub fn remove(&mut self, path: &str) {
        let Some((tables, key)) = path.rsplit_once('.') else { return };
        let mut item = Some(self.0.as_item_mut());
        for table in tables.split('.') {
            item = item.and_then(|item| item.as_table_like_mut()?.get_mut(table));
        }
        if let Some(table) = item.and_then(Item::as_table_like_mut) {
            table.remove(key);
        }
    }
}

/// The table `name` within `parent`, made where it is missing; an implicit one shows no head of its own.
pub(super) fn table<'a>(parent: &'a mut Table, name: &str, implicit: bool) -> &'a mut Table {
    let item = parent.entry(name).or_insert_with(|| {
        let mut new = Table::new();
        new.set_implicit(implicit);
        Item::Table(new)
    });
    if !item.is_table() {
        // `restitution = { value = … }` becomes a table with a head.
        *item = std::mem::take(item).into_table().map_or_else(|_| Item::Table(Table::new()), Item::Table);
    }
    item.as_table_mut().expect("made a table above")
}
