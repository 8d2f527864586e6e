//! The numbers of a message of any type, read by its definition from CDR.
//!
//! Source: OMG DDS-XTypes, plain CDR (XCDR1): every number is aligned to its size, counted from after the four bytes of the mark.

use std::collections::BTreeSet;

use super::mark::{Order, body};
use super::schema::{Field, FieldKind, Fields, Number, Shape};
use super::stamps::joined;

/// Most numbers of one message that make columns: more are a picture, a cloud or a map.
pub(crate) const MOST_COLUMNS: usize = 1_000;

/// Most fields and elements that are walked through in one message: elements of messages without fields take no bytes.
const MOST_STEPS: usize = 4_000_000;

/// Most bytes behind the last field of a message, which fill it up to a multiple of eight: with more, it is of another type.
const MOST_PADDING: usize = 7;

/// The numbers of one message.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Numbers {
    /// The stamp of its header, in ns; `None` without one.
    pub stamp_ns: Option<i64>,
    /// How long after the stamp, or after the time of recording, they hold, in ns.
    pub after_ns: i64,
    /// One for each number: `linear.x`, `data.0`, `position.elbow`. Empty where names were not asked for.
    pub names: Vec<String>,
    pub values: Vec<f64>,
    /// The lengths of its sequences and the names in it: messages with equal ones have equal columns.
    pub layout: Vec<u8>,
}

/// The numbers of `data`, a message with these fields, with their names where these are wanted.
///
/// # Errors
/// Where the bytes do not fit the definition, or there are more numbers than make columns.
pub(crate) fn numbers(fields: &Fields, data: &[u8], names: bool) -> std::result::Result<Numbers, String> {
    let (order, body) = body(data)?;
    let mut walk = Walk {
        body,
        at: 0,
        order,
        found: Numbers::default(),
        names,
        path: String::new(),
        labels: Vec::new(),
        left: MOST_STEPS,
    };
    walk.message(fields)?;
    if walk.body.len() - walk.at > MOST_PADDING {
        return Err(walk.misfit());
    }
    Ok(walk.found)
}

struct Walk<'a> {
    body: &'a [u8],
    at: usize,
    order: Order,
    found: Numbers,
    names: bool,
    /// Where in the message one is: `axes.0`.
    path: String,
    /// Lists of names met on the way, innermost last: they name the elements of sequences of their length.
    labels: Vec<Vec<String>>,
    /// Steps that may still be taken.
    left: usize,
}

type Walked = std::result::Result<(), String>;

impl Walk<'_> {
    fn message(&mut self, fields: &[Field]) -> Walked {
        let known = self.labels.len();
        if fields.is_empty() {
            // ROS 2 writes a byte for a message without fields, since a structure of C needs a member.
            self.take(1, 1)?;
        }
        for field in fields {
            let outer = self.path.len();
            self.enter(&field.name);
            match field.shape {
                Shape::One => self.element(&field.kind)?,
                Shape::Fixed(count) => self.elements(&field.kind, count as usize)?,
                Shape::Sequence => {
                    let count = self.length()?;
                    self.elements(&field.kind, count)?;
                }
            }
            self.path.truncate(outer);
        }
        self.labels.truncate(known);
        Ok(())
    }

    fn enter(&mut self, name: &str) {
        if self.names {
            if !self.path.is_empty() {
                self.path.push('.');
            }
            self.path.push_str(name);
        }
    }

    fn element(&mut self, kind: &FieldKind) -> Walked {
        self.left = self.left.checked_sub(1).ok_or("holds more elements than are read")?;
        match kind {
            FieldKind::Number(number) => {
                let value = self.number(*number)?;
                self.push(value)
            }
            FieldKind::Text => self.text().map(|_| ()),
            FieldKind::Message(fields) => self.message(fields),
            FieldKind::Header(_) => {
                let Stamp { sec, nanosec } = self.stamp()?;
                self.found.stamp_ns.get_or_insert(joined(sec, nanosec).unwrap_or(i64::MAX));
                self.text().map(|_| ())
            }
        }
    }

    fn push(&mut self, value: f64) -> Walked {
        if self.found.values.len() == MOST_COLUMNS {
            return Err(format!("holds more than {MOST_COLUMNS} numbers in a message"));
        }
        self.found.values.push(value);
        if self.names {
            self.found.names.push(self.path.clone());
        }
        Ok(())
    }

    fn elements(&mut self, kind: &FieldKind, count: usize) -> Walked {
        if let FieldKind::Text = kind {
            if count > MOST_COLUMNS {
                return Err(format!("holds more than {MOST_COLUMNS} names in a message"));
            }
            let texts = (0..count).map(|_| self.text()).collect::<std::result::Result<Vec<String>, _>>()?;
            let distinct = self.names && {
                let mut seen = BTreeSet::new();
                texts.iter().all(|text| !text.is_empty() && seen.insert(text))
            };
            for text in &texts {
                self.found.layout.extend(text.as_bytes());
                self.found.layout.push(0);
            }
            if distinct && count > 0 {
                self.labels.push(texts);
            }
            return Ok(());
        }
        let label = self.labels.iter().rposition(|names| names.len() == count);
        for i in 0..count {
            let outer = self.path.len();
            if self.names {
                let name = label.map_or_else(|| i.to_string(), |at| self.labels[at][i].clone());
                self.enter(&name);
            }
            self.element(kind)?;
            self.path.truncate(outer);
        }
        Ok(())
    }
}

/// Seconds and nanoseconds of a stamp.
struct Stamp {
    sec: i64,
    nanosec: i64,
}

impl Walk<'_> {
    /// The next `count` bytes, aligned to so many.
    fn take(&mut self, count: usize, aligned: usize) -> std::result::Result<&[u8], String> {
        let start = self.at.next_multiple_of(aligned);
        let bytes = start.checked_add(count).and_then(|end| self.body.get(start..end));
        let bytes = bytes.ok_or_else(|| self.misfit())?;
        self.at = start + count;
        Ok(bytes)
    }

    fn misfit(&self) -> String {
        format!("{} bytes do not fit its type", self.body.len() + 4)
    }

    fn unsigned(&mut self, bytes: usize) -> std::result::Result<u64, String> {
        let order = self.order;
        let read = self.take(bytes, bytes)?;
        let fold = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        Ok(match order {
            Order::Big => read.iter().fold(0, fold),
            Order::Little => read.iter().rev().fold(0, fold),
        })
    }

    #[expect(clippy::cast_possible_truncation, reason = "as many bits as were read are reinterpreted")]
    fn number(&mut self, number: Number) -> std::result::Result<f64, String> {
        let bits = self.unsigned(number.bytes())?;
        Ok(match number {
            Number::Bool | Number::U8 | Number::U16 | Number::U32 | Number::U64 => bits as f64,
            Number::I8 => f64::from((bits as u8).cast_signed()),
            Number::I16 => f64::from((bits as u16).cast_signed()),
            Number::I32 => f64::from((bits as u32).cast_signed()),
            Number::I64 => bits.cast_signed() as f64,
            Number::F32 => f64::from(f32::from_bits(bits as u32)),
            Number::F64 => f64::from_bits(bits),
        })
    }

    fn stamp(&mut self) -> std::result::Result<Stamp, String> {
        let sec = self.unsigned(4)?;
        let nanosec = self.unsigned(4)?.cast_signed();
        #[expect(clippy::cast_possible_truncation, reason = "four bytes were read")]
        let sec = i64::from((sec as u32).cast_signed());
        Ok(Stamp { sec, nanosec })
    }

    /// A length that the bytes left can hold: what is counted takes a byte at least.
    fn length(&mut self) -> std::result::Result<usize, String> {
        let count = usize::try_from(self.unsigned(4)?).unwrap_or(usize::MAX);
        let left = self.body.len() - self.at;
        if count > left {
            return Err(self.misfit());
        }
        self.found.layout.extend(u32::try_from(count).unwrap_or(u32::MAX).to_le_bytes());
        Ok(count)
    }

    /// Its length counts a closing zero.
    fn text(&mut self) -> std::result::Result<String, String> {
        let count = usize::try_from(self.unsigned(4)?).unwrap_or(usize::MAX);
        let bytes = self.take(count, 1)?;
        let text = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        Ok(String::from_utf8_lossy(text).into_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::super::schema::fields;
    use super::*;

    /// A message by hand, little-endian: the mark, then what follows.
    fn message(parts: &[&[u8]]) -> Vec<u8> {
        [&[0, 1, 0, 0], parts.concat().as_slice()].concat()
    }

    #[test]
    fn validate_alignment_by_hand() {
        let text = "bool on\nfloat64 x\nint16 n\nfloat32 y";
        let fields = fields("odd/A", text, &[]).unwrap();
        let data =
            message(&[&[1], &[0; 7], &1.5f64.to_le_bytes(), &(-2i16).to_le_bytes(), &[0; 2], &2.5f32.to_le_bytes()]);
        let found = numbers(&fields, &data, true).unwrap();
        assert_eq!(found.names, ["on", "x", "n", "y"]);
        assert_eq!(found.values, [1.0, 1.5, -2.0, 2.5]);
        assert!(numbers(&fields, &data[..data.len() - 1], false).unwrap_err().contains("do not fit its type"));
    }

    #[test]
    fn sequences_are_named_by_the_list_of_their_length() {
        let text = "string[] joint_names\nfloat64[] position\nuint8[] modes\nfloat64[2] gains";
        let fields = fields("odd/B", text, &[]).unwrap();
        let name = |text: &[u8]| [&2u32.to_le_bytes(), text, &[0, 0, 0]].concat();
        let data = message(&[
            &2u32.to_le_bytes(),
            &name(b"a"),
            &name(b"b")[..6],
            &[0, 0],
            &2u32.to_le_bytes(),
            &1.0f64.to_le_bytes(),
            &2.0f64.to_le_bytes(),
            &1u32.to_le_bytes(),
            &[7],
            &[0; 3],
            &3.0f64.to_le_bytes(),
            &4.0f64.to_le_bytes(),
        ]);
        let found = numbers(&fields, &data, true).unwrap();
        assert_eq!(found.names, ["position.a", "position.b", "modes.0", "gains.a", "gains.b"]);
        assert_eq!(found.values, [1.0, 2.0, 7.0, 3.0, 4.0]);
    }

    /// `test_msgs/Arrays` of ROS 2 has messages of constants alone between its fields.
    #[test]
    fn a_message_without_fields_takes_a_byte() {
        let fields = fields("odd/A", "odd/E[3] none\nint8 a\n====\nMSG: odd/E\nint8 MOST=7\n", &[]).unwrap();
        assert_eq!(numbers(&fields, &message(&[&[0; 3], &[5]]), true).unwrap().values, [5.0]);
    }

    #[test]
    fn a_message_that_goes_on_behind_its_definition_is_of_another_type() {
        let fields = fields("odd/A", "uint8 level", &[]).unwrap();
        assert_eq!(numbers(&fields, &message(&[&[5], &[0; 7]]), true).unwrap().values, [5.0]);
        let refused = numbers(&fields, &message(&[&[5], &[0; 8]]), true).unwrap_err();
        assert_eq!(refused, "13 bytes do not fit its type");
    }

    #[test]
    fn lengths_of_any_size_are_refused() {
        let fields = fields("std_msgs/Float64MultiArray", "", &[]).unwrap();
        let data = message(&[&u32::MAX.to_le_bytes(), &[0; 8]]);
        assert!(numbers(&fields, &data, false).unwrap_err().contains("do not fit its type"));
        let empties =
            super::super::schema::fields("odd/A", "odd/E[4294967295] all\n====\nMSG: odd/E\nint8[0] none\n", &[])
                .unwrap();
        assert_eq!(numbers(&empties, &data, false).unwrap_err(), "holds more elements than are read");
    }
}
