//! The pages of a column, counted before they are decoded: a page of a few bytes may promise thousands of millions of numbers.

use parquet::basic::Encoding;
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::{ParquetError, Result};

/// Pages with at most so many numbers in all.
pub(super) struct Counted {
    pages: Box<dyn PageReader>,
    /// The page after the last one that was handed over, where it was looked at already. The crate's own look at it panics where a
    /// page has no header of its kind.
    next: Option<Page>,
    /// Numbers that may still come.
    left: usize,
    /// Whether a dictionary came: the crate panics at a page that refers to one where none did.
    dictionary: bool,
}

impl Counted {
    pub fn new(pages: Box<dyn PageReader>, most: usize) -> Self {
        Self { pages, next: None, left: most, dictionary: false }
    }

    /// Looks at the next page.
    fn look(&mut self) -> Result<Option<&Page>> {
        if self.next.is_none() {
            self.next = self.pages.get_next_page()?;
        }
        Ok(self.next.as_ref())
    }
}

impl PageReader for Counted {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        self.look()?;
        let Some(page) = self.next.take() else { return Ok(None) };
        let refers = matches!(page.encoding(), Encoding::RLE_DICTIONARY | Encoding::PLAIN_DICTIONARY);
        match page {
            Page::DictionaryPage { .. } => self.dictionary = true,
            _ if refers && !self.dictionary => {
                return Err(ParquetError::General("a page refers to a dictionary that did not come".into()));
            }
            _ => {}
        }
        let count = usize::try_from(page.num_values()).unwrap_or(usize::MAX);
        self.left = self
            .left
            .checked_sub(count)
            .ok_or_else(|| ParquetError::General("its pages hold more numbers than are read at most".into()))?;
        Ok(Some(page))
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        let about = |page: &Page| match page {
            Page::DataPage { num_values, .. } => {
                PageMetadata { num_rows: None, num_levels: usize::try_from(*num_values).ok(), is_dict: false }
            }
            Page::DataPageV2 { num_values, num_rows, .. } => PageMetadata {
                num_rows: usize::try_from(*num_rows).ok(),
                num_levels: usize::try_from(*num_values).ok(),
                is_dict: false,
            },
            Page::DictionaryPage { .. } => PageMetadata { num_rows: None, num_levels: None, is_dict: true },
        };
        Ok(self.look()?.map(about))
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.get_next_page().map(|_| ())
    }
}

impl Iterator for Counted {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use super::*;

    /// Pages in memory, whose crate would look at a page before it is read.
    struct Made(VecDeque<Page>);

    impl Iterator for Made {
        type Item = Result<Page>;

        fn next(&mut self) -> Option<Self::Item> {
            self.0.pop_front().map(Ok)
        }
    }

    impl PageReader for Made {
        fn get_next_page(&mut self) -> Result<Option<Page>> {
            Ok(self.0.pop_front())
        }

        fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
            panic!("not looked at")
        }

        fn skip_next_page(&mut self) -> Result<()> {
            panic!("not looked at")
        }
    }

    fn page(num_values: u32) -> Page {
        encoded(num_values, Encoding::PLAIN)
    }

    fn encoded(num_values: u32, encoding: Encoding) -> Page {
        let levels = Encoding::RLE;
        Page::DataPage {
            buf: Vec::new().into(),
            num_values,
            encoding,
            def_level_encoding: levels,
            rep_level_encoding: levels,
            statistics: None,
        }
    }

    #[test]
    fn pages_that_promise_more_than_is_read_are_refused_before_they_are_decoded() {
        let mut pages = Counted::new(Box::new(Made([page(3), page(7), page(1)].into())), 10);
        assert!(!pages.at_record_boundary().unwrap());
        assert_eq!(pages.get_next_page().unwrap().unwrap().num_values(), 3);
        assert_eq!(pages.get_next_page().unwrap().unwrap().num_values(), 7);
        assert!(pages.get_next_page().is_err());
        assert!(pages.at_record_boundary().unwrap());
    }

    #[test]
    fn a_page_that_refers_to_a_dictionary_follows_one() {
        let dictionary = || Page::DictionaryPage {
            buf: Vec::new().into(),
            num_values: 2,
            encoding: Encoding::PLAIN,
            is_sorted: false,
        };
        let refers = || encoded(3, Encoding::RLE_DICTIONARY);
        let mut pages = Counted::new(Box::new(Made([dictionary(), refers()].into())), 10);
        assert!(pages.get_next_page().is_ok() && pages.get_next_page().is_ok());
        let mut pages = Counted::new(Box::new(Made([refers(), dictionary()].into())), 10);
        assert!(pages.get_next_page().unwrap_err().to_string().contains("did not come"));
    }
}
