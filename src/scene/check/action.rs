//! What acts on bodies and what is watched: boundaries, loads and probes.

use super::super::{Axis, Body, Load, Quadrature, Signal, Table};
use super::{AXES, Check, SPACE_TIME, TIME};
use crate::scene::fault::{counted, hint, plain};

impl Check<'_> {
    pub(super) fn boundaries(&mut self) {
        let faces: Vec<String> = AXES[..self.dimension].iter().flat_map(|axis| [format!("{axis}-"), format!("{axis}+")]).collect();
        let faces: Vec<&str> = faces.iter().map(String::as_str).collect();
        for (name, boundary) in &self.scene.boundary {
            let path = format!("boundary.{name}");
            let given = [("face", boundary.face.is_some()), ("region", boundary.region.is_some()), ("surface", boundary.surface.is_some())];
            let given: Vec<&str> = given.into_iter().filter(|(_, is)| *is).map(|(key, _)| key).collect();
            match given[..] {
                [] => self.fault(&path, "has none of face, region and surface; must have one of them"),
                [_] => {}
                [..] => self.fault(&path, format!("has {}; must have one of face, region and surface", given.join(" and "))),
            }
            if let Some(face) = &boundary.face {
                self.require(faces.contains(&face.as_str()), &format!("{path}.face"), || format!("is \"{face}\"{}", hint(face, &faces)));
            }
            if let Some(region) = &boundary.region {
                let path = format!("{path}.region");
                if self.region(&path, region) {
                    self.touches_grid(&path, region);
                }
            }
            if let Some(surface) = &boundary.surface {
                let path = format!("{path}.surface");
                self.face(&path, &surface.body, &surface.face);
                let method = &self.scene.method;
                let has = self.dimension > 1 && method.is_total() || method.quadrature == Quadrature::Splines;
                self.require(has, &path, || {
                    "is for quadrature = \"splines\", and for formulation = \"total\" in dimension 2 and 3; take a face or a region".into()
                });
            }
            let holds = !boundary.fixed.is_empty() || !boundary.velocity.is_empty();
            self.require(holds, &path, || "holds nothing; must have fixed or velocity".into());
            for (index, axis) in boundary.fixed.iter().enumerate() {
                let path = format!("{path}.fixed[{index}]");
                self.axis(&path, *axis);
                let once = self.require(!boundary.fixed[..index].contains(axis), &path, || format!("names {} twice", axis_name(*axis)));
                self.require(!once || !boundary.velocity.contains_key(axis), &path, || {
                    format!("fixes {}, whose velocity is prescribed too", axis_name(*axis))
                });
            }
            for (axis, velocity) in &boundary.velocity {
                let path = format!("{path}.velocity.{}", axis_name(*axis));
                self.axis(&path, *axis);
                self.formula(&path, velocity, &TIME, Some(&[0.0]));
            }
        }
    }

    fn axis(&mut self, path: &str, axis: Axis) {
        let dimension = self.dimension;
        self.require((axis as usize) < dimension, path, || {
            format!("is axis {}; dimension {dimension} has {}", axis_name(axis), AXES[..dimension].join(", "))
        });
    }

    pub(super) fn loads(&mut self) {
        let dimension = self.dimension;
        for (name, load) in &self.scene.load {
            let path = format!("load.{name}");
            match load {
                Load::Gravity(value) => self.signal(&format!("{path}.gravity"), value, dimension, &TIME),
                Load::BodyForce(force) => {
                    let path = format!("{path}.body_force");
                    self.body(&format!("{path}.body"), &force.body);
                    if let Some(region) = &force.region {
                        self.region(&format!("{path}.region"), region);
                    }
                    self.signal(&format!("{path}.value"), &force.value, dimension, &SPACE_TIME);
                }
                Load::Traction(traction) => {
                    let path = format!("{path}.traction");
                    self.face(&path, &traction.body, &traction.face);
                    self.signal(&format!("{path}.value"), &traction.value, dimension, &SPACE_TIME);
                }
                Load::Pressure(pressure) => {
                    let path = format!("{path}.pressure");
                    self.face(&path, &pressure.body, &pressure.face);
                    self.signal(&format!("{path}.value"), &pressure.value, 1, &SPACE_TIME);
                }
                Load::PointForce(force) => {
                    let path = format!("{path}.point_force");
                    let body = self.body(&format!("{path}.body"), &force.body);
                    self.point(&format!("{path}.at"), &force.at, &force.body, body);
                    self.signal(&format!("{path}.value"), &force.value, dimension, &TIME);
                }
            }
        }
    }

    pub(super) fn probes(&mut self) {
        let scene = self.scene;
        for (name, probe) in &scene.probe {
            let path = format!("probe.{name}");
            let only = scene.body.first().filter(|_| scene.body.len() == 1);
            let (body_name, body) = match (&probe.body, only) {
                (Some(body), _) => (body.as_str(), self.body(&format!("{path}.body"), body)),
                (None, Some((name, body))) => (name.as_str(), Some(body)),
                (None, None) => {
                    // Without any body there is a fault already.
                    let names: Vec<&str> = scene.body.keys().map(String::as_str).collect();
                    self.require(names.is_empty(), &path, || format!("must say which body, as there are several: {}", names.join(", ")));
                    ("", None)
                }
            };
            self.point(&format!("{path}.at"), &probe.at, body_name, body);
        }
    }

    /// Faults of a point that belongs to a body.
    fn point(&mut self, path: &str, at: &[f64], name: &str, body: Option<&Body>) {
        if self.vector(path, at)
            && let Some(body) = body
        {
            self.near(path, at, name, &body.shape);
        }
    }

    fn face(&mut self, path: &str, body: &str, face: &str) {
        let Some(shape) = self.body(&format!("{path}.body"), body).map(|body| &body.shape) else { return };
        if !self.fits(shape) {
            return;
        }
        let faces = shape.faces();
        let names: Vec<&str> = faces.iter().map(|face| face.name.as_str()).collect();
        let path = format!("{path}.face");
        if names.is_empty() {
            self.fault(&path, format!("body `{body}` has no faces"));
        } else {
            self.require(names.contains(&face), &path, || format!("body `{body}` has no face `{face}`{}", hint(face, &names)));
        }
    }

    fn signal(&mut self, path: &str, signal: &Signal, components: usize, variables: &[&'static str]) {
        match signal {
            Signal::Components(values) => {
                self.components(path, values.len(), components);
                for (index, value) in values.iter().enumerate() {
                    self.formula(&format!("{path}[{index}]"), value, variables, None);
                }
            }
            Signal::Table(table) => self.table(path, table, components),
            Signal::External(_) => {}
        }
    }

    fn table(&mut self, path: &str, table: &Table, components: usize) {
        let (times, values) = (format!("{path}.time"), format!("{path}.value"));
        self.require(!table.time.is_empty(), &times, || "is empty; must have at least one row".into());
        self.require(table.time.len() == table.value.len(), &values, || {
            format!("has {} for {}; must have as many", counted(table.value.len(), "row"), counted(table.time.len(), "time"))
        });
        if self.finite(&times, &table.time)
            && let Some(index) = (1..table.time.len()).find(|&i| table.time[i] <= table.time[i - 1])
        {
            let (before, time) = (plain(table.time[index - 1]), plain(table.time[index]));
            self.fault(&format!("{times}[{index}]"), format!("is {time} after {before}; times must increase"));
        }
        for (index, row) in table.value.iter().enumerate() {
            let path = format!("{values}[{index}]");
            if self.components(&path, row.len(), components) {
                self.finite(&path, row);
            }
        }
    }
}

fn axis_name(axis: Axis) -> &'static str {
    AXES[axis as usize]
}
