//! A trajectory as a table: one row a sample, one column a number.
//!
//! Nodes have columns of their own, `x_00_m`, `z_00_m`, …, rather than one column of lists: CSV and
//! MATLAB's `parquetread` know no lists, pandas plots `df.filter(regex="^x_")` directly, and in
//! SQL `select time_s, z_31_m` reads that column alone. Each name ends in its unit, which also
//! is in the column's metadata under `unit`.
//!
//! A pressure that changes has the column `pressure_Pa`, and each load that depends on time the resultant of its forces, such
//! as `motor_x_N` and `motor_z_N`.
//!
//! With an effect on what is observed there are also `seen_tip_x_m` and `seen_tip_z_m`: where a
//! recording shows the tip at the time of the row by its own clock.

use std::io::{self, Write};

use efam_core::trajectory::Trajectory;
use efam_store::columns::{Cells, Column, CsvFile, Holds, ParquetFile};
use models::line::RodPressure;
use models::model::Model;
use models::system::System;
use serde::ser::{Serialize, SerializeMap, Serializer};

use crate::drive::timed_loads;

/// Numbers held at once while writing; a row group has as many.
const MOST_CELLS: usize = 1 << 22;
/// Columns whose values only a run that follows its energy has.
const FOLLOWED: [&str; 3] = ["dissipated_J", "supplied_J", "total_J"];

/// Columns of a node: two coordinates and their rates.
const OF_A_NODE: usize = 4;

/// A trajectory column by column. In JSON it is an object of lists, in the order of the table.
pub struct Series(Vec<(String, Vec<f64>)>);

impl Serialize for Series {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(self.0.len()))?;
        self.0.iter().try_for_each(|(name, numbers)| map.serialize_entry(name, numbers))?;
        map.end()
    }
}

/// A trajectory, row by row.
pub struct Table<'a> {
    model: &'a Model,
    pressure: RodPressure<'a>,
    trajectory: &'a Trajectory,
    energy_followed: bool,
    /// Indices of the loads that depend on time.
    loads: Vec<usize>,
    columns: Vec<Column>,
}

impl<'a> Table<'a> {
    /// The table of a trajectory; without energy followed in the run, dissipated, supplied and total
    /// energy stay empty.
    pub fn new(model: &'a Model, trajectory: &'a Trajectory, energy_followed: bool) -> Self {
        let loads = timed_loads(model);
        let columns = columns(model, &loads, energy_followed);
        Self { model, pressure: RodPressure::of(model), trajectory, energy_followed, loads, columns }
    }

    /// Its columns.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// All numbers, one sample after another, each in the order of the columns.
    pub fn numbers(&self) -> Vec<f64> {
        let mut system = System::new(self.model);
        let samples = self.trajectory.times.len();
        let mut numbers = Vec::with_capacity(samples * self.columns.len());
        (0..samples).for_each(|sample| self.row(&mut system, sample, &mut numbers));
        numbers
    }

    /// Its columns one by one, without those that hold nothing, and with those of nodes where they are wanted.
    pub fn series(&self, nodes: bool) -> Series {
        let (numbers, width) = (self.numbers(), self.columns.len());
        let shown = if nodes { width } else { width - OF_A_NODE * (self.model.edges + 1) };
        let column = |k: usize| numbers.iter().skip(k).step_by(width).copied().collect();
        let holds = |(_, own): &(usize, &Column)| own.holds != Holds::Nothing;
        let named = |(k, own): (usize, &Column)| (own.name.clone(), column(k));
        Series(self.columns[..shown].iter().enumerate().filter(holds).map(named).collect())
    }

    /// Writes Parquet; `about` becomes the file's key-value metadata.
    /// # Errors
    /// An error of the writer.
    pub fn write_parquet<W: Write + Send>(&self, to: W, about: &[(&str, String)]) -> io::Result<()> {
        let mut file = ParquetFile::begin(to, &self.columns, about)?;
        self.chunks(&mut |chunk| file.write(chunk))?;
        file.finish()
    }

    /// Writes CSV with the same columns; numbers read back to the same bits.
    /// # Errors
    /// An error of the writer.
    pub fn write_csv(&self, to: impl Write) -> io::Result<()> {
        let mut file = CsvFile::begin(to, &self.columns)?;
        self.chunks(&mut |chunk| file.write(&chunk))?;
        file.finish()
    }

    /// Hands over the columns, some rows at a time.
    fn chunks(&self, take: &mut dyn FnMut(Vec<Cells>) -> io::Result<()>) -> io::Result<()> {
        let samples = self.trajectory.times.len();
        let rows = (MOST_CELLS / self.columns.len()).max(1);
        let mut system = System::new(self.model);
        let mut row = Vec::with_capacity(self.columns.len());
        for first in (0..samples).step_by(rows) {
            let last = (first + rows).min(samples);
            let mut chunk = vec![Vec::with_capacity(last - first); self.columns.len()];
            for sample in first..last {
                row.clear();
                self.row(&mut system, sample, &mut row);
                assert_eq!(row.len(), chunk.len(), "as many numbers as columns");
                chunk.iter_mut().zip(&row).for_each(|(column, value)| column.push(*value));
            }
            take(chunk.into_iter().map(Cells::from).collect())?;
        }
        Ok(())
    }

    /// The numbers of a sample, in the order of [`columns`].
    fn row(&self, system: &mut System, sample: usize, row: &mut Vec<f64>) {
        let trajectory = self.trajectory;
        let state = trajectory.state(sample);
        let energy = if self.energy_followed {
            trajectory.energy[sample]
        } else {
            let (kinetic, elastic, potential) = system.energy(state.time, &state.q, &state.v, &state.z);
            models::snapshot::Energy { kinetic, elastic, potential, ..Default::default() }
        };
        let posture = system.assembly.posture(&state.q, &state.v);
        row.push(state.time);
        row.extend(trajectory.tip[sample]);
        row.extend(trajectory.tip_velocity[sample]);
        if self.model.has_sensor() {
            // A recording whose clock lags shows the end of the run after its end.
            row.extend(trajectory.seen_tip.get(sample).copied().unwrap_or([f64::NAN; 2]));
        }
        row.extend([posture.angle, posture.rate]);
        row.extend([energy.kinetic, energy.elastic, energy.potential, energy.dissipated, energy.supplied]);
        row.push(energy.total());
        if self.model.schedule.is_some() {
            row.push(self.pressure.at(state.time));
        }
        for load in &self.loads {
            let nodes = system.forces_of(*load, state.time, &state.q, &state.v, &state.z).unwrap_or_default();
            row.extend(nodes.iter().fold([0.0; 2], |sum, force| [sum[0] + force[0], sum[1] + force[1]]));
        }
        for (position, velocity) in posture.nodes.iter().zip(&posture.velocities) {
            row.extend(position);
            row.extend(velocity);
        }
    }
}

fn columns(model: &Model, loads: &[usize], energy_followed: bool) -> Vec<Column> {
    let (edges, has_sensor) = (model.edges, model.has_sensor());
    let named = |(name, unit): (&str, &'static str)| {
        let is_empty = !energy_followed && FOLLOWED.contains(&name);
        let holds = if is_empty { Holds::Nothing } else { Holds::Numbers };
        Column { name: name.to_owned(), unit, holds }
    };
    let mut columns: Vec<Column> = [
        ("time_s", "s"),
        ("tip_x_m", "m"),
        ("tip_z_m", "m"),
        ("tip_vx_m_s", "m/s"),
        ("tip_vz_m_s", "m/s"),
        ("seen_tip_x_m", "m"),
        ("seen_tip_z_m", "m"),
        ("body_angle_rad", "rad"),
        ("body_rate_rad_s", "rad/s"),
        ("kinetic_J", "J"),
        ("elastic_J", "J"),
        ("potential_J", "J"),
        ("dissipated_J", "J"),
        ("supplied_J", "J"),
        ("total_J", "J"),
    ]
    .map(named)
    .into();
    columns.retain(|column| has_sensor || !column.name.starts_with("seen_"));
    if model.schedule.is_some() {
        columns.push(Column { name: "pressure_Pa".to_owned(), unit: "Pa", holds: Holds::Numbers });
    }
    for load in loads {
        let effect = model.effects[*load].effect.about().name;
        let column =
            |axis: &str| Column { name: format!("{effect}_{axis}_N"), unit: "N", holds: Holds::Numbers };
        columns.extend(["x", "z"].map(column));
    }
    let width = edges.to_string().len().max(2);
    for node in 0..=edges {
        for (what, suffix, unit) in
            [("x", "m", "m"), ("z", "m", "m"), ("vx", "m_s", "m/s"), ("vz", "m_s", "m/s")]
        {
            let name = format!("{what}_{node:0width$}_{suffix}");
            columns.push(Column { name, unit, holds: Holds::Numbers });
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use arrow_array::{Float64Array, RecordBatch};
    use bytes::Bytes;
    use efam_core::example::{muscle_at_15_psi, released, spec_at_15_psi};
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use parquet::file::metadata::KeyValue;

    use super::*;

    #[test]
    fn parquet_reads_back_to_the_same_bits_with_units_and_metadata() {
        let model = muscle_at_15_psi();
        let (_, trajectory) = released(&model, 0.1);
        let table = Table::new(&model, &trajectory, true);
        let mut file = Vec::new();
        table.write_parquet(&mut file, &[("status", "complete".to_owned())]).unwrap();

        let reader = ParquetRecordBatchReaderBuilder::try_new(Bytes::from(file)).unwrap();
        let entries = reader.metadata().file_metadata().key_value_metadata().unwrap().clone();
        assert!(entries.contains(&KeyValue::new("status".to_owned(), "complete".to_owned())));
        let schema = reader.schema().clone();
        let batches: Vec<_> = reader.build().unwrap().map(Result::unwrap).collect();
        assert_eq!(batches.iter().map(RecordBatch::num_rows).sum::<usize>(), trajectory.times.len());
        let column = |name: &str| -> Vec<f64> {
            let of = |batch: &RecordBatch| {
                let array = batch.column_by_name(name).unwrap().clone();
                array.as_any().downcast_ref::<Float64Array>().unwrap().values().to_vec()
            };
            batches.iter().flat_map(of).collect()
        };
        assert_eq!(column("time_s"), trajectory.times);
        assert_eq!(column("tip_z_m"), trajectory.tip_z());
        let vx: Vec<f64> = trajectory.tip_velocity.iter().map(|v| v[0]).collect();
        assert_eq!(column("tip_vx_m_s"), vx);
        let dissipated: Vec<f64> = trajectory.energy.iter().map(|energy| energy.dissipated).collect();
        assert_eq!(column("dissipated_J"), dissipated);
        // Node 1 is the first two coordinates.
        let z_1: Vec<f64> = (0..trajectory.times.len()).map(|k| trajectory.state(k).q[1]).collect();
        assert_eq!(column("z_01_m"), z_1);
        assert_eq!(column("z_00_m"), vec![0.0; z_1.len()]);
        assert!(schema.field_with_name("z_31_m").is_ok() && schema.field_with_name("z_32_m").is_err());
        for (name, unit) in [("tip_z_m", "m"), ("vz_31_m_s", "m/s"), ("body_angle_rad", "rad")] {
            assert_eq!(schema.field_with_name(name).unwrap().metadata()["unit"], unit);
        }
    }

    #[test]
    fn csv_has_the_same_columns_and_numbers() {
        let model = muscle_at_15_psi();
        let (_, trajectory) = released(&model, 0.05);
        let table = Table::new(&model, &trajectory, true);
        let mut file = Vec::new();
        table.write_csv(&mut file).unwrap();
        let text = String::from_utf8(file).unwrap();
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        let names: Vec<&str> = table.columns().iter().map(|column| column.name.as_str()).collect();
        assert_eq!(lines[0], names);
        assert_eq!(lines.len(), 1 + trajectory.times.len());
        let last: Vec<f64> = lines[lines.len() - 1].iter().map(|text| text.parse().unwrap()).collect();
        let [tip_x, tip_z] = trajectory.tip[trajectory.tip.len() - 1];
        assert_eq!(last[..3], [trajectory.times[trajectory.times.len() - 1], tip_x, tip_z]);
    }

    #[test]
    fn energy_that_was_not_followed_is_empty_and_the_rest_is_there() {
        let model = muscle_at_15_psi();
        let (_, trajectory) = released(&model, 0.02);
        let with = Table::new(&model, &trajectory, true);
        let mut without = trajectory.clone();
        without.energy.fill(Default::default());
        let table = Table::new(&model, &without, false);
        let [mut expected, mut found] = [Vec::new(), Vec::new()];
        with.write_csv(&mut expected).unwrap();
        table.write_csv(&mut found).unwrap();
        let row = |file: &[u8]| -> Vec<String> {
            let text = String::from_utf8_lossy(file);
            text.lines().last().unwrap().split(',').map(str::to_owned).collect()
        };
        let (expected, found) = (row(&expected), row(&found));
        for (k, column) in table.columns().iter().enumerate() {
            let due = if FOLLOWED.contains(&column.name.as_str()) { "" } else { expected[k].as_str() };
            assert_eq!(found[k], due, "{}", column.name);
        }
    }

    #[test]
    fn what_a_recording_shows_stands_beside_the_tip() {
        let mut spec = spec_at_15_psi();
        let plain = Table::new(&muscle_at_15_psi(), &Trajectory::default(), true).columns().len();
        spec.effects.push(("scale".to_owned(), vec![("relative_error".to_owned(), 0.1)]));
        let model = Model::new(&spec).unwrap();
        let (_, trajectory) = released(&model, 0.02);
        let table = Table::new(&model, &trajectory, true);
        assert_eq!(table.columns().len(), plain + 2);
        let mut file = Vec::new();
        table.write_csv(&mut file).unwrap();
        let text = String::from_utf8(file).unwrap();
        let column = |name: &str| table.columns().iter().position(|column| column.name == name).unwrap();
        let last: Vec<f64> =
            text.lines().last().unwrap().split(',').map(|text| text.parse().unwrap()).collect();
        for axis in ["x", "z"] {
            let [seen, tip] =
                [format!("seen_tip_{axis}_m"), format!("tip_{axis}_m")].map(|name| last[column(&name)]);
            assert!((seen - 1.1 * tip).abs() < 1e-15, "{seen}, {tip}");
        }
    }

    #[test]
    fn a_run_without_samples_is_a_table_without_rows() {
        let model = muscle_at_15_psi();
        let nothing = Trajectory::default();
        let table = Table::new(&model, &nothing, true);
        let [mut parquet, mut csv] = [Vec::new(), Vec::new()];
        table.write_parquet(&mut parquet, &[]).unwrap();
        table.write_csv(&mut csv).unwrap();
        let reader = ParquetRecordBatchReaderBuilder::try_new(Bytes::from(parquet)).unwrap();
        assert_eq!(reader.metadata().file_metadata().num_rows(), 0);
        assert_eq!(String::from_utf8(csv).unwrap().lines().count(), 1);
    }
}
