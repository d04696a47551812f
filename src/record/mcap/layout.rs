//! The particles as `sensor_msgs/PointCloud2`, there and back. The names of the fields are those of the node.

use super::super::Precision;
use super::super::data::{About, Column, Frame};
use crate::messages::{Bytes, Header, PointCloud2, PointField};
use std::sync::Arc;

const UINT32: u8 = 6;
const FLOAT32: u8 = 7;
const FLOAT64: u8 = 8;

/// Where each number of a particle stands in a point.
pub(super) struct Layout {
    fields: Vec<PointField>,
    /// For each field: column, index in its values, offset, type.
    places: Vec<(usize, usize, usize, u8)>,
    step: usize,
    dimension: usize,
    widths: Vec<usize>,
    /// Columns that are symmetric tensors: stored once, read back twice.
    symmetric: Vec<usize>,
}

impl Layout {
    pub(super) fn new(about: &About) -> Self {
        let mut layout = Self {
            fields: Vec::new(),
            places: Vec::new(),
            step: 0,
            dimension: about.dimension(),
            widths: about.columns.iter().map(|c| c.width).collect(),
            symmetric: Vec::new(),
        };
        let (float, bytes) = if about.precision == Precision::Double { (FLOAT64, 8) } else { (FLOAT32, 4) };
        for (index, column) in about.columns.iter().enumerate() {
            let (datatype, size) = if column.name == "body" { (UINT32, 4) } else { (float, bytes) };
            for (name, component) in names(column, about.dimension()) {
                layout.fields.push(PointField { name, offset: layout.step as u32, datatype, count: 1 });
                layout.places.push((index, component, layout.step, datatype));
                layout.step += size;
            }
            if column.width == 9 && column.components.len() == 6 {
                layout.symmetric.push(index);
            }
        }
        layout
    }

    pub(super) fn point_step(&self) -> usize {
        self.step
    }

    pub(super) fn cloud(&self, header: Header, frame: &Frame) -> PointCloud2 {
        let points = frame.values.first().map_or(0, |v| v.len() / self.dimension);
        let mut data = vec![0; points * self.step];
        for &(column, component, offset, datatype) in &self.places {
            let (values, width) = (&frame.values[column], self.widths[column]);
            // A missing axis stays zero.
            if component >= width {
                continue;
            }
            let values = values.iter().skip(component).step_by(width);
            for (point, &value) in data.chunks_exact_mut(self.step).zip(values) {
                match datatype {
                    FLOAT32 => point[offset..offset + 4].copy_from_slice(&(value as f32).to_le_bytes()),
                    FLOAT64 => point[offset..offset + 8].copy_from_slice(&value.to_le_bytes()),
                    _ => point[offset..offset + 4].copy_from_slice(&(value as u32).to_le_bytes()),
                }
            }
        }
        PointCloud2::row(header, self.fields.clone(), self.step, Bytes(Arc::new(data)))
    }

    /// The frame of a cloud; `None` if the cloud is laid out differently.
    pub(super) fn frame(&self, cloud: &PointCloud2, time: f64, step: u64) -> Option<Frame> {
        if cloud.fields != self.fields || cloud.data.0.len() != cloud.width as usize * self.step {
            return None;
        }
        let points = cloud.width as usize;
        let mut values: Vec<Vec<f64>> = self.widths.iter().map(|width| vec![0.0; points * width]).collect();
        for &(column, component, offset, datatype) in &self.places {
            let width = self.widths[column];
            if component >= width {
                continue;
            }
            for (point, value) in cloud.data.0.chunks_exact(self.step).zip(values[column].iter_mut().skip(component).step_by(width)) {
                *value = match (datatype, &point[offset..]) {
                    (FLOAT32, &[a, b, c, d, ..]) => f64::from(f32::from_le_bytes([a, b, c, d])),
                    (FLOAT64, &[a, b, c, d, e, f, g, h, ..]) => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
                    (_, &[a, b, c, d, ..]) => f64::from(u32::from_le_bytes([a, b, c, d])),
                    _ => return None,
                };
            }
        }
        for &column in &self.symmetric {
            for tensor in values[column].chunks_exact_mut(9) {
                (tensor[3], tensor[6], tensor[7]) = (tensor[1], tensor[2], tensor[5]);
            }
        }
        Some(Frame { time, step, values: values.into_iter().map(Arc::new).collect() })
    }
}

/// The name of each field of a column, with the index of its number. Positions always have three: viewers insist.
fn names(column: &Column, dimension: usize) -> Vec<(String, usize)> {
    const AXES: [&str; 3] = ["x", "y", "z"];
    let before = match column.name.as_str() {
        "position" => Some(""),
        "velocity" => Some("v"),
        "displacement" => Some("d"),
        _ => None,
    };
    match before {
        Some(before) => AXES
            .iter()
            .enumerate()
            .map(|(axis, name)| (format!("{before}{name}"), if axis < dimension { axis } else { usize::MAX }))
            .collect(),
        None => column
            .components
            .iter()
            .map(|&(label, index)| (if label.is_empty() { column.name.clone() } else { format!("{}_{label}", column.name) }, index))
            .collect(),
    }
}
