//! Where a rod starts: what `[release]` says of it.

use models::effects::Catalogue;

use super::document::{Document, Keys};
use super::error::{ScenarioError, ScenarioProblem};
use super::posture;
use super::tables::{EffectPlan, read_effects, read_file, read_rod};
use super::units::ROD;

/// Where the rod starts.
#[derive(Clone, Debug)]
pub(crate) enum From {
    Straight,
    /// At rest while a string or a hand holds the end in the direction of the release angle.
    HeldBy(Holder),
    Equilibrium(Hold),
    /// Points with velocities: x, z, vx, vz.
    Points(Vec<[f64; 4]>),
}

/// What holds the end of a rod.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Holder {
    /// Pulls at right angles to the clamp, and lets the end turn.
    #[default]
    String,
    /// Keeps the end body at the release angle as well.
    Hand,
}

/// What is different while the rod is held.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hold {
    pub pressure: Option<f64>,
    pub rod: [Option<f64>; 6],
    pub effects: Vec<EffectPlan>,
}

/// The words of `release.from`.
#[derive(Clone, Copy, PartialEq)]
enum Start {
    Straight,
    Held,
    Equilibrium,
}

/// Whether a straight rod at `angle` would be bent by a finite angle in no length where it leaves its clamp.
pub(super) fn is_kinked(base_angle: f64, angle: f64) -> bool {
    (angle - base_angle).abs() > 1e-9
}

/// Where the rod starts. `is_kinked` says whether a straight rod would have a kink at its clamp: the energy of a kink
/// is infinite, and on a mesh whatever the mesh makes of it.
pub(super) fn read_from(
    document: &Document,
    release: &Keys,
    has_muscle: bool,
    is_kinked: bool,
    catalogue: &Catalogue,
) -> Result<From, ScenarioError> {
    let hold = release.table("hold")?;
    let starts = [("straight", Start::Straight), ("held", Start::Held), ("equilibrium", Start::Equilibrium)];
    let from = release.word("from", &starts)?;
    if hold.is_given() && from != Some(Start::Equilibrium) {
        let message = "only an equilibrium is held; write from = \"equilibrium\" in [release]".to_owned();
        return Err(document.error_of("release.hold", ScenarioProblem::Other { message }));
    }
    if release.has("by") && matches!(from, Some(Start::Straight | Start::Equilibrium)) {
        let message = "only a rod that starts from = \"held\" is held by something".to_owned();
        return Err(release.wrong("by", ScenarioProblem::Other { message }));
    }
    if is_kinked && from == Some(Start::Straight) {
        let message = "a straight rod at another angle than rod.base_angle has a kink at its clamp, whose energy \
                       grows with every node; leave from out, or write from = \"held\": a string (by = \"hand\": a \
                       hand) holds the tip in the direction of release.angle, and the clamped rod bends to it"
            .to_owned();
        return Err(release.wrong("from", ScenarioProblem::Other { message }));
    }
    for key in ["posture", "nodes"] {
        if from.is_some() && release.has(key) {
            let message = "a release has one start; keep either this or from".to_owned();
            return Err(release.wrong(key, ScenarioProblem::Other { message }));
        }
    }
    if release.has("posture") {
        let (file, text) = read_file(document, release, "posture")?;
        return (posture::read(&file, &text).map(From::Points))
            .map_err(|error| release.wrong("posture", *error));
    }
    if let Some(rows) = release.rows("nodes", &["m", "m", "m/s", "m/s"], "a row of x, z, vx, vz")? {
        let points: Vec<_> = rows.iter().map(|row| [row[0], row[1], row[2], row[3]]).collect();
        posture::check(&points)
            .map_err(|(_, message)| release.wrong("nodes", ScenarioProblem::Other { message }))?;
        return Ok(From::Points(points));
    }
    if release.has("nodes") {
        return Err(release.wrong("nodes", ScenarioProblem::WrongType { due: "rows of x, z, vx, vz" }));
    }
    match from {
        Some(Start::Equilibrium) => {}
        Some(Start::Straight) => return Ok(From::Straight),
        None if !is_kinked && !release.has("by") => return Ok(From::Straight),
        None | Some(Start::Held) => {
            if release.quantity("angular_velocity", "rad/s")?.is_some_and(|rate| rate != 0.0) {
                let message = "a rod that is held is at rest; leave it out, or write 0".to_owned();
                return Err(release.wrong("angular_velocity", ScenarioProblem::Other { message }));
            }
            let by = release.word("by", &[("string", Holder::String), ("hand", Holder::Hand)])?;
            return Ok(From::HeldBy(by.unwrap_or_default()));
        }
    }
    hold.only(&["pressure", "rod", "effects"])?;
    if hold.has("pressure") && !has_muscle {
        let message = "a rod without [muscle] has no pressure; give release.hold.rod instead".to_owned();
        return Err(hold.wrong("pressure", ScenarioProblem::Other { message }));
    }
    let rod = hold.table("rod")?;
    rod.only(&ROD.map(|(key, _)| key))?;
    Ok(From::Equilibrium(Hold {
        pressure: hold.quantity("pressure", "Pa")?,
        rod: read_rod(&rod)?,
        effects: read_effects(&hold.table("effects")?, catalogue)?,
    }))
}
