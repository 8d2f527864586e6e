//! Shares and their differences, with standard errors.

use serde_json::{Value, json};

/// A share with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    pub value: f64,
    pub count: usize,
}

impl Share {
    pub fn from_hits(hits: impl Iterator<Item = bool>) -> Self {
        let (mut count, mut yes) = (0_usize, 0.0);
        for hit in hits {
            count += 1;
            yes += f64::from(u8::from(hit));
        }
        Self { value: if count == 0 { f64::NAN } else { yes / count as f64 }, count }
    }

    pub fn error(self) -> f64 {
        (self.value * (1.0 - self.value) / self.count.max(1) as f64).sqrt()
    }

    pub fn words(self) -> String {
        if self.count == 0 { "-".into() } else { format!("{:.3} ± {:.3}", self.value, self.error()) }
    }

    /// NaN is no JSON.
    pub fn json(self) -> Value {
        if self.count == 0 { Value::Null } else { json!(self.value) }
    }
}

/// A mean difference with its standard error.
pub struct Difference {
    pub mean: f64,
    pub error: f64,
}

impl Difference {
    /// Of single differences, at least one.
    pub fn from_differences(each: &[f64]) -> Self {
        let n = each.len() as f64;
        let mean = each.iter().sum::<f64>() / n;
        let square = each.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / n;
        Self { mean, error: (square / n).sqrt() }
    }

    pub fn words(&self) -> String {
        format!("{:+.3} ± {:.3}", self.mean, self.error)
    }

    pub fn json(&self) -> Value {
        json!({ "mean": self.mean, "se": self.error })
    }
}
