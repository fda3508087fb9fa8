//! The effects that a model may have.

use std::fmt;
use std::sync::Arc;

use thiserror::Error;

use super::{CATALOGUE, Effect, Parameter, by_name};

/// The effects that a model may have: those of [`CATALOGUE`], and behind them laws that were read from text.
///
/// ```
/// use models::effects::Catalogue;
///
/// let catalogue = Catalogue::default();
/// assert!(catalogue.by_name("air_drag").is_some());
/// assert!(catalogue.by_name("my_drag").is_none());
/// ```
#[derive(Clone, Default)]
pub struct Catalogue {
    written: Arc<[&'static dyn Effect]>,
}

/// Two effects would have the same name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("an effect of this name is in the catalogue; choose another name")]
pub struct NameTaken;

impl Catalogue {
    /// The same with one more effect; one that it has already is not added again.
    /// # Errors
    /// [`NameTaken`].
    pub fn with(&self, effect: &'static dyn Effect) -> Result<Self, NameTaken> {
        match self.by_name(effect.about().name) {
            Some(known) if known.text().is_some() && known.text() == effect.text() => Ok(self.clone()),
            Some(_) => Err(NameTaken),
            None => Ok(Self { written: self.written.iter().copied().chain([effect]).collect() }),
        }
    }

    /// All effects, in the order in which a model has them.
    pub fn iter(&self) -> impl Iterator<Item = &'static dyn Effect> + Clone + '_ {
        CATALOGUE.iter().copied().chain(self.written.iter().copied())
    }

    /// Those that were read from text.
    pub fn written(&self) -> &[&'static dyn Effect] {
        &self.written
    }

    /// The effect of that name.
    pub fn by_name(&self, name: &str) -> Option<&'static dyn Effect> {
        by_name(name).or_else(|| self.written.iter().copied().find(|effect| effect.about().name == name))
    }

    /// A parameter by its path, such as `effects.payload.mass`.
    pub fn parameter(&self, path: &str) -> Option<&'static Parameter> {
        let (effect, name) = path.strip_prefix("effects.")?.split_once('.')?;
        self.by_name(effect)?.about().parameters.iter().find(|own| own.name == name)
    }

    /// Paths of all parameters, such as `effects.payload.mass`.
    pub fn paths(&self) -> impl Iterator<Item = String> {
        self.iter().map(|effect| effect.about()).flat_map(|about| {
            about.parameters.iter().map(|own| format!("effects.{}.{}", about.name, own.name))
        })
    }

    /// Place of an effect in the order of the catalogue.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.iter().position(|effect| effect.about().name == name)
    }
}

impl fmt::Debug for Catalogue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.written.iter().map(|effect| effect.about().name)).finish()
    }
}
