//! `<default>` classes. A nested class starts as a copy of the one around it, whose own elements count wherever they stand.

use std::collections::HashMap;
use std::rc::Rc;

use super::actuator::Servo;
use super::known::{self, ACTUATORS, OTHER_ACTUATORS};
use crate::Result;
use crate::given::Given;
use crate::xml::{Attribute, Document, Element, shown};

/// The class that everything belongs to that names none.
const MAIN: &str = "main";

/// What a class gives to elements of it.
#[derive(Debug, Clone)]
pub(super) struct Class {
    pub joint: Vec<Rc<Attribute>>,
    pub geom: Vec<Rc<Attribute>>,
    pub equality: Vec<Rc<Attribute>>,
    /// All kinds of actuators share one.
    pub actuator: Servo,
}

/// The classes by name.
#[derive(Debug, Clone)]
pub(super) struct Classes {
    by_name: HashMap<String, Class>,
}

impl Classes {
    /// The classes of a document.
    pub fn read(document: &Document) -> Result<Self> {
        let main = Class { joint: Vec::new(), geom: Vec::new(), equality: Vec::new(), actuator: Servo::default() };
        let mut new = Self { by_name: HashMap::from([(MAIN.to_owned(), main)]) };
        let mut top = MAIN.to_owned();
        for element in document.root.named("default") {
            let own = element.value("class").filter(|name| !name.is_empty());
            if let Some(name) = own.filter(|name| *name != top) {
                // The outermost class has this name from here on; what names none still belongs to it.
                let class = new.by_name[&top].clone();
                new.by_name.insert(name.to_owned(), class);
                top = name.to_owned();
            }
            new.section(document, element, &top)?;
        }
        if top != MAIN {
            let class = new.by_name[&top].clone();
            new.by_name.insert(MAIN.to_owned(), class);
        }
        Ok(new)
    }

    fn section(&mut self, document: &Document, section: &Element, name: &str) -> Result<()> {
        let mut class = self.by_name[name].clone();
        for element in section.children.iter().filter(|child| child.tag != "default") {
            class.update(document, element)?;
        }
        self.by_name.insert(name.to_owned(), class);
        for nested in section.named("default") {
            let Some(own) = nested.value("class").filter(|name| !name.is_empty()) else {
                let message = "expected a nested <default> to have a class, found none";
                return Err(document.error_at(nested, message, "write <default class=\"arm\">, say"));
            };
            if own == MAIN || self.by_name.contains_key(own) {
                let message = format!("expected each class once, found `{}` twice", shown(own));
                return Err(document.error_at(nested, message, "rename one of them"));
            }
            let class = self.by_name[name].clone();
            self.by_name.insert(own.to_owned(), class);
            self.section(document, nested, own)?;
        }
        Ok(())
    }

    /// The class of an element: its own, or the nearest `childclass` around it.
    ///
    /// # Errors
    /// [`Error::Text`](crate::Error::Text) where there is none of this name.
    pub fn of(&self, document: &Document, element: &Element, around: Option<&str>) -> Result<&Class> {
        let name = element.value("class").or(around).unwrap_or(MAIN);
        self.by_name.get(name).ok_or_else(|| {
            let mut known: Vec<_> = self.by_name.keys().map(|name| format!("`{}`", shown(name))).collect();
            known.sort();
            known.truncate(20);
            let message = format!("expected a class of <default> ({}), found `{}`", known.join(", "), shown(name));
            document.error_at(element, message, "correct the name, or include the file with its <default>")
        })
    }
}

impl Class {
    fn update(&mut self, document: &Document, element: &Element) -> Result<()> {
        let list = match element.tag.as_str() {
            "joint" => &mut self.joint,
            "geom" => &mut self.geom,
            "equality" => &mut self.equality,
            tag if ACTUATORS.contains(&tag) || OTHER_ACTUATORS.contains(&tag) => {
                return self.actuator.update(&Given::own(document, element));
            }
            _ => return Ok(()),
        };
        for attribute in &element.attributes {
            let name = attribute.name.as_str();
            // Not taken on, but edits have to know of the first, and who asks whether shapes touch of the masks.
            let noted = matches!(name, "springdamper" | "contype" | "conaffinity");
            let known = noted || known::taken(&element.tag).contains(&name);
            if known || known::places(&element.tag, name) {
                list.retain(|old| old.name != attribute.name);
                list.push(attribute.clone());
            }
        }
        Ok(())
    }
}
