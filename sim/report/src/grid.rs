//! What predictions over pressures and payloads leave on disk, and their table.
//!
//! ```text
//! outputs/<UTC>_<name>_<hash8>/
//!   report.html              all of it, for people
//!   grid.json                every number of every case, with intervals; warnings
//!   grid.parquet, grid.csv   the same, one row a case
//!   over-payload.svg, over-pressure.svg, map-….svg    the pictures
//!   scenario.resolved.toml   the first case, for `efam simulate`
//!   summary.json             the request, and its command
//! ```

use std::fmt::Write;
use std::io;
use std::time::SystemTime;

use efam_inference::predict::grid::{Cell, Grid};
use efam_inference::predict::quantity::units;
use efam_store::StoreError;
use efam_store::columns::{Cells, Column, CsvFile, Holds, ParquetFile};
use efam_store::folder::Folder;
use serde_json::json;

use crate::aligned::{Aligned, Side};
use crate::page::REPORT;
use crate::picture::{PASCAL_PER_PSI, grid_pictures};
use crate::predicted::answers::answers;
use crate::predicted::page::of_several;
use crate::report::{readable, significant};
use crate::{Request, SCENARIO, write_mark};

/// The numbers.
pub const GRID: &str = "grid.json";
/// The same, one row a case.
pub const PARQUET: &str = "grid.parquet";
/// The same as text.
pub const CSV: &str = "grid.csv";

/// Writes a grid into an open folder.
/// # Errors
/// [`StoreError::Write`].
pub fn write_grid(folder: &Folder, request: &Request, grid: &Grid) -> Result<(), StoreError> {
    let text = serde_json::to_string_pretty(grid).expect("a grid has nothing that JSON has not");
    folder.write(GRID, text.as_bytes())?;
    let (columns, values) = columns(grid);
    let about = [("run", request.name.clone()), ("efam", env!("CARGO_PKG_VERSION").to_owned())];
    folder.write_with(PARQUET, |file| {
        let mut file = ParquetFile::begin(file, &columns, &about)?;
        file.write(values.clone())?;
        file.finish()
    })?;
    folder.write_with(CSV, |file| -> io::Result<()> {
        let mut file = CsvFile::begin(file, &columns)?;
        file.write(&values)?;
        file.finish()
    })?;
    let (pictures, written) = (grid_pictures(grid), SystemTime::now());
    for picture in &pictures {
        folder.write(&format!("{}.svg", picture.name), picture.svg().as_bytes())?;
    }
    folder.write(REPORT, of_several(request, grid, &pictures, written).as_bytes())?;
    folder.write(SCENARIO, request.resolved_scenario.as_bytes())?;
    write_mark(folder, request, "grid", written, json!({}))
}

/// Pressure, payload, and each number with the ends of its interval; a row for each case.
fn columns(grid: &Grid) -> (Vec<Column>, Vec<Cells>) {
    let mut columns = Vec::new();
    let mut values = Vec::new();
    let mut put = |name: &str, unit: &'static str, of: &dyn Fn(&Cell) -> Option<f64>| {
        columns.push(Column { name: name.to_owned(), unit, holds: Holds::NumbersOrNone });
        let numbers: Vec<f64> = grid.cells.iter().map(|cell| of(cell).unwrap_or(f64::NAN)).collect();
        values.push(Cells::from(numbers));
    };
    put("pressure_pa", "Pa", &|cell| cell.pressure_pa);
    put("payload_kg", "kg", &|cell| Some(cell.payload_kg));
    for (name, unit) in units() {
        put(name, unit, &|cell| cell.quantity(name)?.value);
        put(&format!("{name}_low_95"), unit, &|cell| Some(cell.quantity(name)?.interval_95?[0]));
        put(&format!("{name}_high_95"), unit, &|cell| Some(cell.quantity(name)?.interval_95?[1]));
    }
    (columns, values)
}

/// Names of the numbers that the table shows, and their heads.
const SHOWN: [(&str, &str); 6] = [
    ("rest_z_m", "rest, mm"),
    ("small_frequency_hz", "small, Hz"),
    ("frequency_hz", "released, Hz"),
    ("damping_ratio", "damping"),
    ("settling_5_percent_s", "settled 5 %, s"),
    ("lowest_z_m", "lowest, mm"),
];
/// Cases in the table at most.
const ROWS: usize = 40;

/// A grid as a table for people.
pub fn grid_table(grid: &Grid) -> String {
    let heads =
        ["psi", "kPa", "g"].into_iter().chain(SHOWN.map(|own| own.1)).map(|head| (head, Side::Number));
    let mut table = Aligned::new(&heads.chain([("", Side::Words)]).collect::<Vec<_>>());
    for cell in grid.cells.iter().take(ROWS) {
        let pressure =
            |unit: f64| cell.pressure_pa.map_or("-".to_owned(), |pressure| significant(pressure / unit, 4));
        let mut row = vec![pressure(PASCAL_PER_PSI), pressure(1e3), significant(1e3 * cell.payload_kg, 4)];
        if let Some(why) = &cell.failed {
            row.extend(SHOWN.map(|_| "-".to_owned()));
            row.push(why.clone());
            table.row(row);
            continue;
        }
        for (name, _) in SHOWN {
            let quantity = cell.quantity(name);
            let shown = quantity
                .and_then(|quantity| Some(significant(readable(&quantity.unit).0 * quantity.value?, 4)));
            let half = quantity.and_then(|quantity| {
                let [low, high] = quantity.interval_95?;
                Some(format!("±{}", significant(0.5 * readable(&quantity.unit).0 * (high - low), 2)))
            });
            row.push(format!("{}{}", shown.unwrap_or("-".to_owned()), half.unwrap_or_default()));
        }
        row.push(if cell.extrapolated == Some(true) { "*" } else { "" }.to_owned());
        table.row(row);
    }
    let mut text = format!("{}\n{table}", grid.name);
    if grid.cells.len() > ROWS {
        let _ = writeln!(text, "… and {} more, in {CSV}", grid.cells.len() - ROWS);
    }
    if grid.cells.iter().any(|cell| cell.extrapolated == Some(true)) {
        text += "* outside what was calibrated\n";
    }
    text.push('\n');
    for line in answers(grid) {
        let _ = writeln!(text, "{line}");
    }
    for warning in &grid.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}
