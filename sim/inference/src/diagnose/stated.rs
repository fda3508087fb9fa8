//! What an experiment file says of its diagnosis.
//!
//! ```toml
//! [diagnose]                          # all may be left out
//! without = ["hose"]                  # effects that cannot be there
//! [[diagnose.parameter]]
//! path = "effects.tip_mass.mass"      # of any candidate
//! bounds = ["0 g", "100 g"]           # instead of the range that follows from the rod
//! ```

use efam_experiments::experiment::{Experiment, ExperimentError};
use efam_experiments::scenario::document::Keys;
use efam_experiments::scenario::{ScenarioError, ScenarioProblem};
use models::effects::Catalogue;
use models::nearest::{nearest, offer};

use super::{DiagnosisSettings, known_effects};
use crate::calibrate::{SectionError, repeatability};

impl DiagnosisSettings {
    /// These, with what the experiment says.
    /// # Errors
    /// [`SectionError`], with the place in the file.
    pub fn stated(mut self, experiment: &Experiment) -> Result<Self, SectionError> {
        let section = experiment.section("diagnose")?;
        let catalogue = experiment.catalogue();
        let read = || -> Result<_, ScenarioError> {
            section.only(&["without", "parameter"])?;
            let ranges = section.tables("parameter")?;
            let ranges = ranges.iter().map(|own| range(own, &catalogue)).collect::<Result<_, _>>()?;
            Ok((without(&section, &catalogue)?, ranges))
        };
        let (without, ranges) = read().map_err(ExperimentError::from)?;
        self.excluded.extend(without);
        self.ranges = ranges;
        self.repeatability = repeatability(experiment)?;
        Ok(self)
    }
}

/// Effects that a table leaves out of the catalogue.
/// # Errors
/// [`ScenarioError`] at a name that is none.
pub fn without(table: &Keys, catalogue: &Catalogue) -> Result<Vec<String>, ScenarioError> {
    let names = table.texts("without")?.unwrap_or_default();
    let names: Vec<String> = names.into_iter().map(str::to_owned).collect();
    known_effects(&names, catalogue)
        .map_err(|message| table.wrong("without", ScenarioProblem::Other { message }))?;
    Ok(names)
}

fn range(table: &Keys, catalogue: &Catalogue) -> Result<(String, (f64, f64)), ScenarioError> {
    table.only(&["path", "bounds"])?;
    let Some((path, _)) = table.text("path")? else {
        return Err(table.missing("path", "path = \"effects.tip_mass.mass\""));
    };
    let Some(of) = catalogue.parameter(path) else {
        let known: Vec<String> = catalogue.paths().collect();
        let near = offer(nearest(path, known.iter().map(String::as_str)));
        let message =
            format!("no effect has a parameter `{path}`{near}; `efam effects NAME` lists those of one");
        return Err(table.wrong("path", ScenarioProblem::Other { message }));
    };
    let (least, most) = of.range;
    match table.quantities("bounds", of.unit)?.as_deref() {
        None => Err(table.missing("bounds", "bounds = two values, the lower one first")),
        Some([low, high]) if low < high && least <= *low && *high <= most => {
            Ok((path.to_owned(), (*low, *high)))
        }
        Some(_) => {
            let must = "be two values that the effect admits, the lower one first";
            Err(table.wrong("bounds", ScenarioProblem::Must { must }))
        }
    }
}
