//! Tables: `history.csv` (a row a record time) and `particles.csv` (the last frame).

use super::columns::{self, SYMMETRIC, Series, quoted};
use super::options::free;
use super::particles::von_mises;
use super::{RecordError, Sink};
use crate::Simulation;
use crate::draft::Draft;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Writes `history.csv` and `particles.csv` to a folder.
///
/// Numbers are the shortest text that reads back as the same number. Column names end in the SI unit: `probe_tip_velocity_x_m_per_s`.
pub struct CsvSink {
    folder: PathBuf,
    series: Vec<Series>,
    history: Option<Draft>,
    particles: Option<Draft>,
    line: String,
    files: Vec<PathBuf>,
    force: bool,
}

impl CsvSink {
    /// A sink for `folder`, which is made when the run starts.
    pub fn new(folder: impl AsRef<Path>) -> Self {
        let folder = folder.as_ref().to_path_buf();
        Self { folder, series: Vec::new(), history: None, particles: None, line: String::new(), files: Vec::new(), force: false }
    }

    /// Whether tables that are there are written over.
    pub fn force(self, force: bool) -> Self {
        Self { force, ..self }
    }
}

impl Sink for CsvSink {
    fn begin(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        ["history.csv", "particles.csv"].iter().try_for_each(|name| free(&self.folder.join(name), self.force))?;
        std::fs::create_dir_all(&self.folder).map_err(RecordError::write(&self.folder))?;
        let mut history = Draft::create(&self.folder.join("history.csv"))?;
        self.particles = Some(Draft::create(&self.folder.join("particles.csv"))?);
        self.series = columns::series(&sim.describe());
        let headers = self.series.iter().flat_map(Series::headers);
        history.write(&std::iter::once("time_s".to_owned()).chain(headers).collect::<Vec<_>>().join(","))?;
        history.write("\n")?;
        self.history = Some(history);
        Ok(())
    }

    fn history(&mut self, sim: &mut Simulation, _: u64) -> Result<(), RecordError> {
        self.line.clear();
        number(&mut self.line, sim.time());
        for series in &self.series {
            let values = sim.get(&series.variable)?;
            for &(_, index) in &series.components {
                self.line.push(',');
                number(&mut self.line, values[index]);
            }
        }
        self.line.push('\n');
        self.history.as_mut().map_or(Ok(()), |history| history.write(&self.line))
    }

    fn finish(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        if let Some(history) = self.history.take() {
            self.files.push(history.finish()?);
        }
        if let Some(mut particles) = self.particles.take() {
            write_particles(sim, &mut particles)?;
            self.files.push(particles.finish()?);
        }
        Ok(())
    }

    fn files(&self) -> Vec<PathBuf> {
        self.files.clone()
    }
}

/// Every particle: id, body, position, displacement, velocity, stress, von Mises stress.
fn write_particles(sim: &mut Simulation, out: &mut Draft) -> Result<(), RecordError> {
    let description = sim.describe();
    let dimension = description.dimension;
    let unit = |name: &str| description.variables.iter().find(|v| v.name == name).map_or("", |v| v.unit);
    let vectors = ["particle/position", "particle/displacement", "particle/velocity"];
    let mut line = "id,body".to_owned();
    for name in vectors {
        let short = name.trim_start_matches("particle/");
        for (label, _) in columns::components(name, &[dimension]) {
            let _ = write!(line, ",{}", columns::header(short, label, unit(name)));
        }
    }
    for (label, ..) in SYMMETRIC {
        let _ = write!(line, ",{}", columns::header("stress", label, unit("particle/stress")));
    }
    let _ = writeln!(line, ",{}", columns::header("von_mises", "", unit("particle/stress")));
    out.write(&line)?;

    let names: Vec<String> = description.bodies.iter().map(|(name, _)| quoted(name)).collect();
    let bodies = sim.get("particle/body")?.to_vec();
    let [position, displacement, velocity] = vectors.map(|name| sim.get(name).map(<[f64]>::to_vec));
    let vectors = [position?, displacement?, velocity?];
    let stress = sim.get("particle/stress")?;
    for (id, &body) in bodies.iter().enumerate() {
        line.clear();
        let _ = write!(line, "{id},{}", names.get(body as usize).map_or("", String::as_str));
        let coordinates = vectors.iter().flat_map(|values| &values[id * dimension..(id + 1) * dimension]);
        let tensor = &stress[9 * id..9 * (id + 1)];
        let components = SYMMETRIC.iter().map(|&(_, row, column)| &tensor[3 * row + column]);
        for &value in coordinates.chain(components).chain([&von_mises(tensor)]) {
            line.push(',');
            number(&mut line, value);
        }
        line.push('\n');
        out.write(&line)?;
    }
    Ok(())
}

/// The shortest text that reads back as the same number.
fn number(line: &mut String, value: f64) {
    // Writing to a String cannot fail.
    let _ = write!(line, "{value:?}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_the_same() {
        for value in [0.1, 1.0 / 3.0, -1e-300, 5e-324, 0.1 + 0.2, 1e22] {
            let mut text = String::new();
            number(&mut text, value);
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), value.to_bits());
        }
    }

    #[test]
    fn names_with_commas_are_quoted() {
        assert_eq!(quoted("beam"), "beam");
        assert_eq!(quoted("a,\"b\""), "\"a,\"\"b\"\"\"");
    }
}
