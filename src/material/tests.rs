//! Each law against its own energy, against rotation, and in the small-strain limit.

use super::*;
use crate::scene::Plane;
use nalgebra::{Rotation3, Vector3};

const LAME: Lame = Lame { lambda: 3.0, mu: 2.0 };

fn stretched() -> Matrix3<f64> {
    Matrix3::new(1.2, 0.3, -0.1, 0.05, 0.9, 0.2, 0.1, -0.15, 1.1)
}

fn rotation() -> Matrix3<f64> {
    nalgebra::Rotation3::from_euler_angles(0.3, -0.7, 1.1).into_inner()
}

#[test]
fn stress_is_the_derivative_of_the_energy() {
    let f = stretched();
    for material in [Material::NeoHookean(LAME), Material::Hencky(LAME)] {
        let none = History::default();
        let h = 1e-6;
        // P = dW/dF by central differences; tau = P F^T. Error of the difference: h^2 and round-off 1e-16 / h.
        let p = Matrix3::from_fn(|r, c| {
            let (mut up, mut down) = (f, f);
            up[(r, c)] += h;
            down[(r, c)] -= h;
            (material.energy(&up, &none) - material.energy(&down, &none)) / (2.0 * h)
        });
        let error = (material.kirchhoff(&f, &none) - p * f.transpose()).norm();
        assert!(error < 1e-8, "{material:?}: {error}");
    }
}

#[test]
fn laws_with_a_potential_turn_with_the_body() {
    let (f, r, none) = (stretched(), rotation(), History::default());
    for material in [Material::NeoHookean(LAME), Material::Hencky(LAME)] {
        let turned = material.kirchhoff(&(r * f), &none);
        assert!((turned - r * material.kirchhoff(&f, &none) * r.transpose()).norm() < 1e-13);
        assert!((material.energy(&(r * f), &none) - material.energy(&f, &none)).abs() < 1e-13);
        assert!(material.kirchhoff(&r, &none).norm() < 1e-13, "a rotation is no strain");
    }
}

#[test]
fn all_laws_agree_at_small_strain() {
    let tiny = 1e-6;
    let gradient = stretched() * tiny;
    let linear = LAME.stress(&symmetric(&gradient));
    for material in [Material::Linear(LAME), Material::Hypo(LAME), Material::NeoHookean(LAME), Material::Hencky(LAME)] {
        let mut history = History::default();
        material.update(&mut history, &Increment { gradient, jacobian: 1.0 });
        let f = Matrix3::identity() + gradient;
        let stress = material.kirchhoff(&f, &history);
        // laws differ in the second order of the strain
        assert!((stress - linear).norm() < 10.0 * tiny * linear.norm(), "{material:?}");
        let energy = 0.5 * linear.dot(&symmetric(&gradient));
        assert!((material.energy(&f, &history) - energy).abs() < 20.0 * tiny * energy, "{material:?}");
    }
}

#[test]
fn hypo_elastic_in_one_dimension_is_the_law_of_the_thesis() {
    // sigma' = (E - sigma) eps' integrates to sigma = E (1 - 1/J): exact for any step, since the increment of J is J eps.
    let material = Material::Hypo(Lame { lambda: 0.0, mu: 25.0 });
    let (mut history, mut j) = (History::default(), 1.0);
    for step in 0..200 {
        let strain = 0.01 * (0.1 * step as f64).sin();
        material.update(&mut history, &Increment { gradient: embed(&[[strain]], 0.0), jacobian: j });
        j *= 1.0 + strain;
    }
    let sigma = history[0] / j;
    assert!((sigma - 50.0 * (1.0 - 1.0 / j)).abs() < 1e-12 * 50.0, "{sigma} at J = {j}");
}

#[test]
fn hypo_elastic_keeps_its_stress_in_a_rotating_body() {
    let material = Material::Hypo(LAME);
    let mut history = [1.0, -2.0, 0.5, 0.3, 0.2, -0.7, 0.0];
    let before = stress_of(&history);
    let spin = Vector3::new(0.2, 0.1, 0.3) * 0.01;
    for _ in 0..100 {
        material.update(&mut history, &Increment { gradient: spin.cross_matrix(), jacobian: 1.0 });
    }
    // each step turns by twice the angle whose tangent is half the spin
    let turned = Rotation3::new(spin.normalize() * (200.0 * (0.5 * spin.norm()).atan())).into_inner();
    assert!((stress_of(&history) - turned * before * turned.transpose()).norm() < 1e-13);
    assert!(history[6].abs() < 1e-16, "rotation does no work");
}

#[test]
fn plane_stress_leaves_no_stress_across() {
    let in_plane = [[1.3, 0.2], [0.1, 0.8]];
    let plane = Embedding::new(2, Plane::Stress);
    for material in [Material::NeoHookean(LAME), Material::Hencky(LAME)] {
        let stretch = plane.stress_free_stretch(&material, &in_plane, 1.0).expect("found");
        let stress = material.kirchhoff(&embed(&in_plane, stretch), &History::default());
        assert!(stress[(2, 2)].abs() < 1e-12 * LAME.mu);
    }
    // rate laws: the increment across follows from the in-plane one
    for dimension in [1, 2] {
        let mut history = History::default();
        let gradient = match dimension {
            1 => Embedding::new(1, Plane::Stress).gradient(&LAME, &[[0.01]]),
            _ => plane.gradient(&LAME, &[[0.01, 0.02], [0.0, -0.03]]),
        };
        Material::Linear(LAME).update(&mut history, &Increment { gradient, jacobian: 1.0 });
        assert!(history[2].abs() < 1e-15);
        if dimension == 1 {
            let young = LAME.mu * (3.0 * LAME.lambda + 2.0 * LAME.mu) / (LAME.lambda + LAME.mu);
            assert!((history[0] - 0.01 * young).abs() < 1e-15, "a bar has Young's modulus");
        }
    }
}
