//! What the nodes make of the particles, and what is measured.

use super::Total;
use crate::model::Model;
use crate::state::State;
use crate::step::measure::Measures;
use nalgebra::Vector3;

impl Total {
    /// Shows the particles as the nodes have moved them.
    pub(crate) fn show(&mut self, model: &Model, state: &mut State) {
        for part in &self.parts {
            let reference = &self.bodies[part.body].reference;
            for p in part.first..part.last {
                let mut place = model.reference(p as u32);
                let mut speed = [0.0; 3];
                reference.each_slowly(&reference.particle(p - part.offset), |node, weight, _| {
                    for a in 0..3 {
                        place[a] += weight * state.nodes.displacement[node][a];
                        speed[a] += weight * state.nodes.velocity[node][a];
                    }
                });
                state.particles.position.set_row(p, &place);
                state.particles.velocity.set_row(p, &speed);
            }
        }
    }

    /// Measures the state.
    pub(crate) fn measure(&mut self, model: &Model, state: &State) -> Measures {
        let mut measures = Measures { velocity: state.particles.velocity.clone(), ..Measures::default() };
        let momentum = self.times(model, &state.nodes.velocity);
        let mut angular = Vector3::zeros();
        for body in &self.bodies {
            for i in 0..body.reference.len() {
                let node = body.reference.start + i;
                let (v, p) = (&state.nodes.velocity[node], Vector3::from(momentum[node]));
                measures.kinetic += 0.5 * Vector3::from(*v).dot(&p);
                let place = Vector3::from(body.reference.place(i)) + Vector3::from(state.nodes.displacement[node]);
                angular += place.cross(&p);
                for a in 0..3 {
                    measures.linear[a] += p[a];
                }
            }
        }
        measures.angular = angular.into();
        measures.nodal_kinetic = measures.kinetic;
        let particles = &state.particles;
        for p in 0..particles.len() {
            let f = crate::step::load::deformation(model.dimension, state, p);
            measures.strain += particles.volume[p] * model.material(particles.body[p]).energy(&f, &particles.history.row(p));
        }
        self.probe(model, state, &mut measures);
        measures
    }

    /// Measures the probes of a state, which need its nodes only.
    pub(crate) fn probe(&self, model: &Model, state: &State, measures: &mut Measures) {
        for probe in &model.probes {
            let number = usize::from(state.particles.body[probe.anchor.particle as usize]);
            let reference = &self.bodies[number].reference;
            let host: [f64; 3] = model.reference(probe.anchor.particle);
            let start: [f64; 3] = std::array::from_fn(|a| host[a] + probe.anchor.offset[a]);
            let (mut place, mut speed) = (start, [0.0; 3]);
            reference.each_slowly(&reference.point(start), |node, weight, _| {
                for a in 0..3 {
                    place[a] += weight * state.nodes.displacement[node][a];
                    speed[a] += weight * state.nodes.velocity[node][a];
                }
            });
            measures.probes.push(speed);
            measures.places.push(place);
        }
    }
}
