//! One variable of a recording, as a table.

use super::RecordError;
use super::columns::{header, quoted};
use super::data::{About, Item, Row};
use crate::scene::nearest;

/// A variable chosen by name.
pub struct Chosen {
    name: String,
    unit: &'static str,
    components: Vec<(&'static str, usize)>,
    place: Place,
}

enum Place {
    /// Number of the column, numbers a particle.
    Particles(usize, usize),
    /// Number of the series.
    Series(usize),
}

impl About {
    /// Names and units of all that is recorded.
    pub fn variables(&self) -> Vec<(String, String)> {
        let columns = self.columns.iter().map(|c| (format!("particle/{}", c.name), c.unit.to_owned()));
        let series = self.series.iter().map(|s| (s.variable.clone(), s.unit.to_owned()));
        columns.chain(series).chain(self.inputs.iter().map(|v| (v.name.clone(), v.unit.to_owned()))).collect()
    }

    /// A variable that is recorded.
    ///
    /// # Errors
    /// One that is not: the error names the nearest that is.
    pub fn choose(&self, name: &str) -> Result<Chosen, RecordError> {
        let short = name.trim_start_matches("particle/");
        if let Some(i) = self.column(short) {
            let c = &self.columns[i];
            return Ok(Chosen {
                name: c.name.clone(),
                unit: c.unit,
                components: c.components.clone(),
                place: Place::Particles(i, c.width),
            });
        }
        if let Some(i) = self.series.iter().position(|s| s.variable == name) {
            let s = &self.series[i];
            return Ok(Chosen { name: s.variable.clone(), unit: s.unit, components: s.components.clone(), place: Place::Series(i) });
        }
        if let Some(i) = self.inputs.iter().position(|v| v.name == name) {
            let v = &self.inputs[i];
            let components = super::columns::components(name, &v.shape);
            return Ok(Chosen { name: name.into(), unit: v.unit, components, place: Place::Series(self.series.len() + i) });
        }
        let known: Vec<String> = self.variables().into_iter().map(|(name, _)| name).collect();
        let short = self.columns.iter().map(|c| c.name.as_str());
        let nearest = nearest(name, known.iter().map(String::as_str).chain(short)).map(Into::into);
        Err(RecordError::Variable { name: name.into(), nearest, known: known.join(", ") })
    }

    /// Kinetic, strain and total energy of a row \[J\].
    pub fn energies(&self, row: &Row) -> Option<[f64; 3]> {
        let find = |name: &str| row.values[self.series.iter().position(|s| s.variable == name)?].first().copied();
        Some([find("energy/kinetic")?, find("energy/strain")?, find("energy/total")?])
    }
}

impl Chosen {
    /// The names of the columns of the table.
    pub fn header(&self) -> String {
        let names = self.components.iter().map(|(label, _)| quoted(&header(&self.name, label, self.unit)));
        let first = if matches!(self.place, Place::Particles(..)) { "time_s,id" } else { "time_s" };
        std::iter::once(first.to_owned()).chain(names).collect::<Vec<_>>().join(",")
    }

    /// The lines that an item adds to the table.
    ///
    /// # Errors
    /// What `write` says.
    pub fn lines(&self, item: &Item, write: &mut dyn FnMut(&str) -> std::io::Result<()>) -> std::io::Result<()> {
        let numbers = |values: &[f64]| {
            self.components.iter().map(|&(_, i)| values.get(i).map_or(String::new(), |v| format!("{v:?}"))).collect::<Vec<_>>().join(",")
        };
        match (item, &self.place) {
            (Item::Row(row), Place::Series(i)) => write(&format!("{:?},{}\n", row.time, numbers(&row.values[*i]))),
            (Item::Frame(frame), Place::Particles(i, width)) => {
                let particles = frame.values[*i].chunks_exact(*width).enumerate();
                particles.into_iter().try_for_each(|(id, values)| write(&format!("{:?},{id},{}\n", frame.time, numbers(values))))
            }
            _ => Ok(()),
        }
    }
}
