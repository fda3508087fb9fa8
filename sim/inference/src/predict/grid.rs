//! Predictions over pressures and payloads: every number at each, the payload that takes the tip past straight
//! down, the pressure at which the muscle swings slowest.
//!
//! A hundred cases are too many for hundreds of draws each. Here the errors are carried through the simulation along
//! their principal directions, one standard deviation to either side, or as far as a parameter may go: seven runs a
//! case with three parameters. This is as good as the numbers are linear over one standard deviation.

use std::f64::consts::FRAC_PI_2;

use efam_core::forward::Run;
use efam_core::rest::rest;
use efam_experiments::analysis::brent::{least, root};
use efam_experiments::scenario::{Case, ScenarioError};
use models::muscle::Known;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::errors::Errors;
use super::interval::{Change, carried};
use super::mesh_of;
use super::model_error::ModelError;
use super::quantity::{QUANTITIES, Quantity, units};
use super::simulated::simulate;
use super::warnings::{Extent, outside, warnings};
use crate::ordered::in_order;

/// The number that says whether the tip went past straight down.
const LEAST_ANGLE: &str = "least_angle_rad";

/// Predictions over pressures and payloads; SI.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Grid {
    /// Name of the request.
    pub name: String,
    /// Pressures above ambient, Pa, ascending; none of a rod that is no muscle.
    pub pressures_pa: Vec<f64>,
    /// Masses of the payload, kg, ascending.
    pub payloads_kg: Vec<f64>,
    /// Each pressure with each payload, the payloads of the first pressure first.
    pub cells: Vec<Cell>,
    /// Of each pressure, or of the rod, from which payload on a release takes the tip past straight down.
    pub past_straight_down: Vec<PastStraightDown>,
    /// Of each payload at which pressure small swings are slowest; none with a single pressure.
    pub slowest: Vec<Slowest>,
    /// Caveats of the numbers.
    pub warnings: Vec<String>,
}

/// One pressure with one payload.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Cell {
    /// Pressure above ambient, Pa; none of a rod that is no muscle.
    pub pressure_pa: Option<f64>,
    /// Mass of the payload, kg.
    pub payload_kg: f64,
    /// The numbers; empty where it could not be simulated.
    pub quantities: Vec<Quantity>,
    /// Why it could not be simulated.
    pub failed: Option<String>,
    /// Whether pressure, payload or amplitude lie outside what was calibrated; none without a calibration.
    pub extrapolated: Option<bool>,
}

impl Cell {
    /// A number by its name.
    pub fn quantity(&self, name: &str) -> Option<&Quantity> {
        self.quantities.iter().find(|quantity| quantity.name == name)
    }
}

/// From which payload on a release takes the tip past straight down.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PastStraightDown {
    /// Pressure above ambient, Pa.
    pub pressure_pa: Option<f64>,
    /// The payload, kg; none where it happens at none of the requested payloads, or at all of them.
    pub payload_kg: Option<f64>,
    /// The interval that holds 95 % of what the errors of the calibration admit, kg.
    pub interval_95: Option<[f64; 2]>,
    /// Whether it happens with the lightest payload already.
    pub always: bool,
}

/// Where small swings are slowest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Slowest {
    /// Mass of the payload, kg.
    pub payload_kg: f64,
    /// Pressure, Pa.
    pub pressure_pa: f64,
    /// Natural frequency there, Hz.
    pub frequency_hz: f64,
    /// Its interval, of the nearest requested pressure.
    pub interval_95: Option<[f64; 2]>,
    /// Whether it is the lowest or the highest requested pressure: beyond it may be slower still.
    pub at_end: bool,
}

/// Makes a case at a pressure, Pa, with a payload, kg.
pub type Make<'a> = &'a (dyn Fn(Option<f64>, f64) -> Result<Case, ScenarioError> + Sync);

/// Runs of each case of a grid: two for each number that a calibration knows, and two on finer meshes where it
/// removed that.
pub fn runs(known: Option<&Known>) -> usize {
    let of = |known: &Known| 2 * known.paths().len() + if known.nodes.is_none() { 2 } else { 0 };
    1 + known.map_or(0, of)
}

/// Predicts every pressure with every payload. `tell` is called after each case, from any thread.
/// # Errors
/// [`ScenarioError`] for a case that makes no sense; one that cannot be simulated says so in its cell.
pub fn grid(
    name: &str,
    (pressures, payloads): (&[f64], &[f64]),
    make: Make,
    known: Option<&Known>,
    tell: &(dyn Fn() + Sync),
) -> Result<Grid, ScenarioError> {
    let columns: Vec<Option<f64>> = match pressures {
        [] => vec![None],
        all => all.iter().copied().map(Some).collect(),
    };
    let asked = columns.iter().flat_map(|pressure| payloads.iter().map(|payload| (*pressure, *payload)));
    let cases = asked.map(|(pressure, payload)| make(pressure, payload)).collect::<Result<Vec<_>, _>>()?;
    let (predicted, errors): (Vec<(Cell, f64)>, Vec<Option<Errors>>) = cases
        .par_iter()
        .map(|case| {
            let errors = known.map(|known| Errors::new(known, case));
            let done = predict_case(case, known, errors.as_ref());
            tell();
            (done, errors)
        })
        .unzip();
    let mut grid = Grid {
        name: name.to_owned(),
        pressures_pa: pressures.to_vec(),
        payloads_kg: payloads.to_vec(),
        ..Grid::default()
    };
    let excursion = predicted.iter().map(|(_, excursion)| *excursion).fold(0.0, f64::max);
    grid.cells = predicted.into_iter().map(|(cell, _)| cell).collect();
    // What is sought between the cells has the loss of its frequency, as they have.
    let make: Make = &|pressure, payload| {
        let mut case = make(pressure, payload)?;
        if let Some(known) = known {
            case.model = Errors::new(known, &case).model;
        }
        Ok(case)
    };
    let rows: Vec<&[Cell]> = grid.cells.chunks(payloads.len()).collect();
    let past = rows.par_iter().map(|row| past_straight_down(row, make));
    grid.past_straight_down = in_order::<_, Result<_, ScenarioError>>(past)?;
    if pressures.len() > 1 {
        let of = |k: usize| slowest(&rows.iter().map(|row| &row[k]).collect::<Vec<_>>(), make);
        let all = (0..payloads.len()).into_par_iter().map(of);
        let all = in_order::<_, Result<Vec<Option<Slowest>>, ScenarioError>>(all)?;
        grid.slowest = all.into_iter().flatten().collect();
    }
    let extent = Extent { pressures, payloads, excursion };
    let errors: Vec<Errors> = errors.into_iter().flatten().collect();
    let mut words: Vec<String> = cases.iter().flat_map(|case| case.warnings.clone()).collect();
    words.sort();
    words.dedup();
    grid.warnings = words;
    grid.warnings.extend(warnings(&extent, known, &errors));
    let failed = grid.cells.iter().filter(|cell| cell.failed.is_some()).count();
    if failed > 0 {
        grid.warnings
            .push(format!("{failed} of {} cases could not be simulated; each says why", cases.len()));
    }
    Ok(grid)
}

/// A case with the errors of what is known, and the largest distance of its tip from the rest, m.
fn predict_case(case: &Case, known: Option<&Known>, errors: Option<&Errors>) -> (Cell, f64) {
    let run = Run { energy: false, ..case.run.clone() };
    let mut cell = Cell {
        pressure_pa: case.pressure,
        payload_kg: case.model.value_or_zero("effects.payload.mass"),
        ..Cell::default()
    };
    let model = errors.map_or(&case.model, |errors| &errors.model);
    let mut own = match simulate(model, &run) {
        Ok(own) => own,
        Err(why) => {
            cell.failed = Some(why);
            return (cell, 0.0);
        }
    };
    let change = |errors: &Errors, direction: usize, side: f64| -> Vec<Option<Change>> {
        let (moved, room) = errors.along(direction, side);
        let Some((model, share)) = moved else {
            // Parameters that cannot go there change nothing; a model that cannot be says nothing.
            return vec![(room == 0.0).then_some(Change { slope: 0.0, room }); own.numbers.len()];
        };
        let Ok(moved) = simulate(&model, &run) else { return vec![None; own.numbers.len()] };
        let pairs = moved.numbers.iter().zip(&own.numbers);
        let slope = |(moved, own): (&Option<f64>, &Option<f64>)| {
            Some(Change { slope: (moved.as_ref()? - own.as_ref()?) / share, room })
        };
        pairs.map(slope).collect()
    };
    let both = |errors: &Errors, direction: usize| [-1.0, 1.0].map(|side| change(errors, direction, side));
    let changes: Vec<[Vec<Option<Change>>; 2]> = errors
        .iter()
        .flat_map(|errors| (0..errors.directions()).map(|direction| both(errors, direction)))
        .collect();
    // On one mesh the changes are the same but for a small part of themselves.
    mesh_of(known, &own, model, &run).iter().for_each(|mesh| mesh.removed(&mut own));
    let model_error = known.and_then(|known| ModelError::of(known, case, &own));
    cell.quantities = own.quantities(|k, value| {
        let interval = carried(value, changes.iter().map(|[low, high]| [low[k], high[k]]))?;
        let widened = |error: &ModelError| error.widened(QUANTITIES[k].off, value, interval);
        known.map(|_| model_error.as_ref().map_or(interval, widened))
    });
    cell.extrapolated = known.map(|known| {
        let extent = Extent {
            pressures: case.pressure.as_slice(),
            payloads: &[cell.payload_kg],
            excursion: own.excursion,
        };
        !outside(&extent, known).is_empty()
    });
    (cell, own.excursion)
}

/// What is least of the tip's angle, rad, beyond straight down; its half interval.
fn beyond(cell: &Cell) -> Option<(f64, f64)> {
    let quantity = cell.quantity(LEAST_ANGLE)?;
    let half = quantity.interval_95.map_or(0.0, |[low, high]| 0.5 * (high - low));
    Some((quantity.value? + FRAC_PI_2, half))
}

fn past_straight_down(row: &[Cell], make: Make) -> Result<PastStraightDown, ScenarioError> {
    let pressure = row.first().and_then(|cell| cell.pressure_pa);
    let known: Vec<(f64, f64, f64)> = row
        .iter()
        .filter_map(|cell| beyond(cell).map(|(angle, half)| (cell.payload_kg, angle, half)))
        .collect();
    let always = known.first().is_some_and(|(_, angle, _)| *angle < 0.0);
    let crosses = |pair: &&[(f64, f64, f64)]| pair[0].1 >= 0.0 && pair[1].1 < 0.0;
    let none = PastStraightDown { pressure_pa: pressure, payload_kg: None, interval_95: None, always };
    let Some([low, high]) = known.windows(2).find(crosses).and_then(|pair| <[_; 2]>::try_from(pair).ok())
    else {
        return Ok(none);
    };
    let mut refused = None;
    let payload = root(low.0..high.0, |payload| {
        let case = make(pressure, payload).map_err(|error| refused = Some(error)).ok()?;
        let run = Run { energy: false, ..case.run.clone() };
        let k = units().position(|(name, _)| name == LEAST_ANGLE)?;
        Some(simulate(&case.model, &run).ok()?.numbers[k]? + FRAC_PI_2)
    });
    if let Some(error) = refused {
        return Err(error);
    }
    let slope = (high.1 - low.1) / (high.0 - low.0);
    let half = 0.5 * (low.2 + high.2) / slope.abs();
    let interval = payload.filter(|_| half > 0.0).map(|payload| [(payload - half).max(0.0), payload + half]);
    Ok(PastStraightDown { payload_kg: payload, interval_95: interval, ..none })
}

fn slowest(cells: &[&Cell], make: Make) -> Result<Option<Slowest>, ScenarioError> {
    let name = "small_frequency_hz";
    let of = |cell: &Cell| cell.quantity(name).and_then(|quantity| quantity.value);
    let known: Vec<(&Cell, f64)> = cells.iter().filter_map(|cell| Some((*cell, of(cell)?))).collect();
    let Some(at) = (0..known.len()).min_by(|a, b| known[*a].1.total_cmp(&known[*b].1)) else {
        return Ok(None);
    };
    let pressure = |k: usize| known[k].0.pressure_pa.unwrap_or(0.0);
    let (cell, frequency) = known[at];
    let interval = cell.quantity(name).and_then(|quantity| quantity.interval_95);
    let mut slowest = Slowest {
        payload_kg: cell.payload_kg,
        pressure_pa: pressure(at),
        frequency_hz: frequency,
        interval_95: interval,
        at_end: at == 0 || at + 1 == known.len(),
    };
    if slowest.at_end {
        return Ok(Some(slowest));
    }
    let mut refused = None;
    let mut frequency_at = |pressure: f64| {
        let case = make(Some(pressure), cell.payload_kg).map_err(|error| refused = Some(error)).ok()?;
        let modes = rest(&case.model, case.run.duration, 1).ok()?.modes.ok()?;
        modes.first().map(|(frequency, _)| *frequency)
    };
    if let Some(at) = least(pressure(at - 1)..pressure(at + 1), &mut frequency_at) {
        let found = frequency_at(at).filter(|found| *found <= slowest.frequency_hz);
        if let Some(found) = found {
            let moved = found - slowest.frequency_hz;
            slowest.interval_95 = interval.map(|ends| ends.map(|end| end + moved));
            (slowest.pressure_pa, slowest.frequency_hz) = (at, found);
        }
    }
    refused.map_or(Ok(Some(slowest)), Err)
}
