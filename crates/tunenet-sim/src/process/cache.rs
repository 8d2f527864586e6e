//! What was answered already: equal requests are asked once.

use std::collections::HashMap;
use std::sync::Arc;

use super::protocol::Answer;
use super::request::Request;

/// Most numbers that are kept: 64 MiB.
const MOST_NUMBERS: usize = 1 << 23;

/// Answers by what was asked.
#[derive(Debug, Default)]
pub(super) struct Cache {
    /// `None` where the answer is awaited.
    known: HashMap<Arc<Request>, Option<Arc<Answer>>>,
    numbers: usize,
}

/// What is known of a request.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Known {
    /// It was not asked for.
    No,
    /// Its answer is awaited.
    Awaited,
    /// It was answered.
    Answered(Arc<Answer>),
}

impl Cache {
    /// What is known of a request.
    pub fn of(&self, request: &Request) -> Known {
        match self.known.get(request) {
            None => Known::No,
            Some(None) => Known::Awaited,
            Some(Some(answer)) => Known::Answered(Arc::clone(answer)),
        }
    }

    /// The answer to this request is awaited.
    pub fn awaits(&mut self, request: &Arc<Request>) {
        self.known.insert(Arc::clone(request), None);
    }

    /// Keeps an answer. Where there are too many, those before are dropped.
    pub fn keep(&mut self, request: &Arc<Request>, answer: Answer) {
        let size = request.len() + answer.len();
        if self.numbers + size > MOST_NUMBERS {
            self.known.retain(|_, answer| answer.is_none());
            self.numbers = 0;
        }
        self.numbers += size;
        self.known.insert(Arc::clone(request), Some(Arc::new(answer)));
    }
}

#[cfg(test)]
mod tests {
    use super::super::request::tests::request;
    use super::*;

    #[test]
    fn what_is_kept_has_an_end_and_what_is_awaited_is_not_dropped() {
        let (first, awaited) = (Arc::new(request(&[1.0], &[0.0])), Arc::new(request(&[2.0], &[0.0])));
        let mut cache = Cache::default();
        assert_eq!(cache.of(&first), Known::No);
        cache.awaits(&first);
        cache.awaits(&awaited);
        assert_eq!(cache.of(&first), Known::Awaited);
        cache.keep(&first, Answer::Values(vec![3.0]));
        assert_eq!(cache.of(&first), Known::Answered(Arc::new(Answer::Values(vec![3.0]))));
        let large = Arc::new(request(&[3.0], &[0.0]));
        cache.keep(&large, Answer::Values(vec![0.0; MOST_NUMBERS]));
        assert_eq!((cache.of(&first), cache.of(&awaited)), (Known::No, Known::Awaited));
    }
}
