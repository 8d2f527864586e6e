//! Numbers and words of attributes.

use std::rc::Rc;

use crate::xml::{Attribute, Document, Element, shown};
use crate::{Error, Result};

/// The attributes of an element over those of its class.
#[derive(Clone, Copy)]
pub(crate) struct Given<'a> {
    pub document: &'a Document,
    pub own: &'a Element,
    pub class: Option<&'a [Rc<Attribute>]>,
}

impl<'a> Given<'a> {
    pub fn own(document: &'a Document, own: &'a Element) -> Self {
        Self { document, own, class: None }
    }

    pub fn get(&self, name: &str) -> Option<&'a Attribute> {
        let of_class = || self.class.and_then(|class| class.iter().find(|a| a.name == name));
        self.own.attribute(name).or_else(of_class).map(|a| &**a)
    }

    pub fn text(&self, name: &str) -> Option<&'a str> {
        self.get(name).map(|a| a.value.as_str())
    }

    /// One number.
    pub fn number(&self, name: &str) -> Result<Option<f64>> {
        Ok(self.numbers::<1>(name)?.map(|[number]| number))
    }

    /// Exactly so many numbers.
    pub fn numbers<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>> {
        let Some(attribute) = self.get(name) else { return Ok(None) };
        let list = list(self.document, attribute)?;
        let count = list.len();
        let array: std::result::Result<[f64; N], _> = list.try_into();
        array.map(Some).map_err(|_| {
            let expected = if N == 1 { "a number".into() } else { format!("{N} numbers") };
            self.document.error(
                attribute,
                format!("`{name}`: expected {expected}, found {count}"),
                "correct the attribute",
            )
        })
    }

    /// At most so many numbers, over those of `values`; returns whether the attribute is there.
    pub fn fill(&self, name: &str, values: &mut [f64]) -> Result<bool> {
        let Some(attribute) = self.get(name) else { return Ok(false) };
        let list = list(self.document, attribute)?;
        if list.len() > values.len() {
            let message = format!("`{name}`: expected at most {} numbers, found {}", values.len(), list.len());
            return Err(self.document.error(attribute, message, "correct the attribute"));
        }
        values[..list.len()].copy_from_slice(&list);
        Ok(true)
    }

    /// One of these words.
    pub fn word<T: Copy>(&self, name: &str, words: &[(&str, T)]) -> Result<Option<T>> {
        let Some(attribute) = self.get(name) else { return Ok(None) };
        let found = words.iter().find(|(word, _)| *word == attribute.value).map(|(_, value)| *value);
        found.map(Some).ok_or_else(|| {
            let words: Vec<_> = words.iter().map(|(word, _)| format!("`{word}`")).collect();
            let message = format!("`{name}`: expected {}, found `{}`", words.join(", "), shown(&attribute.value));
            self.document.error(attribute, message, "correct the attribute")
        })
    }

    pub fn flag(&self, name: &str) -> Result<Option<bool>> {
        self.word(name, &[("true", true), ("false", false)])
    }

    /// `None` both where it is absent and where it is `auto`.
    pub fn flag_or_auto(&self, name: &str) -> Result<Option<bool>> {
        Ok(self.word(name, &[("true", Some(true)), ("false", Some(false)), ("auto", None)])?.flatten())
    }

    /// An error at the attribute, or at the element where it is absent.
    pub fn error(&self, name: &str, message: impl Into<String>, hint: &str) -> Error {
        match self.get(name) {
            Some(attribute) => self.document.error(attribute, message, hint),
            None => self.document.error_at(self.own, message, hint),
        }
    }

    /// A number that is 0 or more; `absent` where it is not there.
    pub fn not_negative(&self, name: &str, absent: f64) -> Result<f64> {
        let value = self.number(name)?.unwrap_or(absent);
        if value >= 0.0 {
            return Ok(value);
        }
        Err(self.error(name, format!("`{name}`: expected 0 or more, found {value}"), "correct the attribute"))
    }
}

/// The numbers of an attribute, all finite.
fn list(document: &Document, attribute: &Attribute) -> Result<Vec<f64>> {
    let number = |word: &str| {
        let parsed = word.parse::<f64>().ok().filter(|n| n.is_finite());
        parsed.ok_or_else(|| {
            let message = format!("`{}`: expected finite numbers, found `{}`", attribute.name, shown(word));
            document.error(attribute, message, "mend the number")
        })
    };
    attribute.value.split_ascii_whitespace().map(number).collect()
}
