//! The known solution: its formulas and its reference file.

use super::super::StressComponent;
use super::{Check, SPACE_TIME};
use std::fs::File;
use std::io::{BufRead, BufReader};

/// The columns of a reference file.
const COLUMNS: &str = "time_s,X_m,displacement_m,velocity_m_s,stress_Pa";
/// Most rows of a reference file; one row takes 40 bytes.
const MOST_ROWS: usize = 10_000_000;
/// Longest line of a reference file \[bytes\]: five numbers are far shorter.
const LONGEST_LINE: u64 = 1000;
/// How much of a wrong line is shown \[characters\].
const SHOWN: usize = 80;

impl Check<'_> {
    pub(super) fn exact(&mut self) {
        let Some(exact) = &self.scene.exact else { return };
        for (path, formulas) in [("exact.displacement", &exact.displacement), ("exact.velocity", &exact.velocity)] {
            if !formulas.is_empty() {
                self.components(path, formulas.len(), self.dimension);
            }
            for (index, formula) in formulas.iter().enumerate() {
                self.formula(&format!("{path}[{index}]"), formula, &SPACE_TIME, None);
            }
        }
        for (component, formula) in &exact.stress {
            let (name, shears) = match component {
                StressComponent::Xx => ("xx", None),
                StressComponent::Yy => ("yy", None),
                StressComponent::Zz => ("zz", None),
                StressComponent::Xy => ("xy", Some(2)),
                StressComponent::Xz => ("xz", Some(3)),
                StressComponent::Yz => ("yz", Some(3)),
            };
            let path = format!("exact.stress.{name}");
            // The normal stresses across a plane or an axis are there in every dimension; shear needs both of its axes.
            let dimension = self.dimension;
            self.require(shears.is_none_or(|least| dimension >= least), &path, || format!("is always zero in dimension {dimension}"));
            self.formula(&path, formula, &SPACE_TIME, None);
        }
        if let Some(reference) = &exact.reference {
            let dimension = self.dimension;
            self.require(dimension == 1, "exact.reference", || format!("is for dimension 1; the scene has dimension {dimension}"));
            if let Err(message) = read_reference(reference) {
                self.fault("exact.reference", format!("\"{reference}\" {message}"));
            }
        }
    }
}

/// Says what is wrong with a reference file.
fn read_reference(path: &str) -> Result<(), String> {
    let unread = |error: std::io::Error| format!("cannot be read: {error}");
    let mut file = BufReader::new(File::open(path).map_err(unread)?);
    let mut line = String::new();
    for number in 1.. {
        line.clear();
        let length = std::io::Read::take(&mut file, LONGEST_LINE).read_line(&mut line).map_err(unread)?;
        let row = line.trim();
        let shown: String = row.chars().take(SHOWN).collect();
        match (number, length) {
            (1, _) if row != COLUMNS => return Err(format!("has the first line \"{shown}\"; must be \"{COLUMNS}\"")),
            (1, _) => {}
            (2, 0) => return Err("has no rows".into()),
            (_, 0) => break,
            _ if number - 1 > MOST_ROWS => return Err(format!("has more than {MOST_ROWS} rows")),
            _ => {
                let finite = |field: &str| field.trim().parse::<f64>().is_ok_and(f64::is_finite);
                if row.split(',').count() != 5 || !row.split(',').all(finite) {
                    return Err(format!("has \"{shown}\" on line {number}; must be 5 finite numbers with commas between"));
                }
            }
        }
    }
    Ok(())
}
