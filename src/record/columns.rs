//! Names for the components of variables, one place for every table.

use crate::component::{Causality, Description, Variable};

/// The components of a symmetric 3x3 tensor that are written: label, row, column.
pub(super) const SYMMETRIC: [(&str, usize, usize); 6] =
    [("xx", 0, 0), ("yy", 1, 1), ("zz", 2, 2), ("yz", 1, 2), ("xz", 0, 2), ("xy", 0, 1)];

/// The components of any 3x3 tensor in C-order.
const FULL: [&str; 9] = ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"];

const AXES: [&str; 3] = ["x", "y", "z"];

/// A variable of the history: an energy, a momentum, a probe, a reaction or an error.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Series {
    /// Name, as `get` takes it.
    pub(crate) variable: String,
    /// SI unit, empty for pure numbers.
    pub(crate) unit: &'static str,
    /// Label (empty for a scalar) and index of each value that is written.
    pub(crate) components: Vec<(&'static str, usize)>,
}

/// All series of a simulation, in the order of its variables.
pub(super) fn series(description: &Description) -> Vec<Series> {
    let varies = |v: &&Variable| v.causality == Causality::Output && !v.name.starts_with("particle/") && !v.is_empty();
    let series = |v: &Variable| Series { variable: v.name.clone(), unit: v.unit, components: components(&v.name, &v.shape) };
    description.variables.iter().filter(varies).map(series).collect()
}

impl Series {
    /// A series of one number.
    pub(super) fn scalar(variable: &str, unit: &'static str) -> Self {
        Self { variable: variable.into(), unit, components: vec![("", 0)] }
    }

    /// Column names with units, such as `probe_tip_displacement_x_m`.
    pub(super) fn headers(&self) -> impl Iterator<Item = String> + '_ {
        self.components.iter().map(|(label, _)| header(&self.variable, label, self.unit))
    }
}

/// Labels and flat indices of the components of one value of `shape`.
pub(super) fn components(variable: &str, shape: &[usize]) -> Vec<(&'static str, usize)> {
    match *shape {
        [] => vec![("", 0)],
        // The one tensor that is not symmetric.
        [3, 3] if variable.ends_with("/deformation_gradient") => FULL.iter().enumerate().map(|(index, &label)| (label, index)).collect(),
        [3, 3] => SYMMETRIC.iter().map(|&(label, row, column)| (label, 3 * row + column)).collect(),
        [2] if variable.starts_with("error/") => vec![("rms", 0), ("max", 1)],
        // The only component of an angular momentum in the plane points out of it.
        [1] if variable.ends_with("/angular") => vec![("z", 0)],
        [n] if n <= 3 => (0..n).map(|axis| (AXES[axis], axis)).collect(),
        _ => Vec::new(),
    }
}

/// Column name from the name of a variable, the label of a component and a unit: words joined by `_`.
pub(super) fn header(variable: &str, label: &str, unit: &str) -> String {
    // `J/m` and `J m` must not look the same.
    let unit = unit.replace('/', "_per_").replace([' ', '*', '.'], "_").replace('^', "");
    let name = variable.replace('/', "_");
    [name.as_str(), label, unit.as_str()].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_")
}

/// A name as a CSV field: in quotes where it holds a comma, a quote or a line end.
pub(super) fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_name_component_and_unit() {
        let headers = |variable: &str, unit, shape: &[usize]| {
            let series = Series { variable: variable.into(), unit, components: components(variable, shape) };
            series.headers().collect::<Vec<_>>()
        };
        assert_eq!(headers("energy/kinetic", "J/m", &[]), ["energy_kinetic_J_per_m"]);
        assert_eq!(headers("probe/tip/displacement", "m", &[2]), ["probe_tip_displacement_x_m", "probe_tip_displacement_y_m"]);
        assert_eq!(headers("momentum/angular", "kg m2/s", &[1]), ["momentum_angular_z_kg_m2_per_s"]);
        assert_eq!(headers("error/stress", "Pa", &[2]), ["error_stress_rms_Pa", "error_stress_max_Pa"]);
        assert_eq!(headers("probe/tip/stress", "Pa", &[3, 3])[3], "probe_tip_stress_yz_Pa");
    }
}
