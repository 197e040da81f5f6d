//! What users write in TOML, and the place of what cannot be read in it.

use std::ops::Range;

use serde::de::DeserializeOwned;

use crate::error::Error;
use crate::excerpt::Excerpt;

/// A text in TOML; `help` says what it should be.
pub fn toml<T: DeserializeOwned>(name: &str, text: &str, help: &str) -> Result<T, Error> {
    toml::from_str(text).map_err(|error| {
        let span = error.span().unwrap_or(0..0);
        fault(name, text, span, error.message(), help)
    })
}

/// Something at a place of a text.
pub fn fault(name: &str, text: &str, span: Range<usize>, message: &str, help: &str) -> Error {
    let excerpt = Excerpt::new(name, text.as_bytes(), span);
    Error::malformed(message.trim_end().to_owned(), help.to_owned(), excerpt, "here".to_owned())
}
