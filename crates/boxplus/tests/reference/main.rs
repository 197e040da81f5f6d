//! Every operation against arbitrary-precision truth (`scripts/*_tables.py`), in units of ε.
//!
//! Errors are normwise, block by block, so that a large translation cannot hide a wrong rotation. The bounds asserted
//! here are the ones stated in `docs/accuracy.md`; `BOXPLUS_BLESS=1 cargo test --test reference` writes that file.
#![allow(missing_docs, clippy::unwrap_used, clippy::float_cmp)] // exact: is an input representable?

mod bounds;
mod elementary;
mod judge;
mod plane;
mod second_order;
mod space;

use bounds::{BOUNDS, Bound, NONE};
use boxplus::lie::{Real, Stumpff};
use elementary::elementary;
use judge::{Errors, LAST, Table};
use plane::{plane, similarity_of_the_plane};
use second_order::second_order;
use space::{galilean, similarity_of_space, space};
use std::fmt::Write;

fn coefficients<S: Real>(table: &Table, errors: &mut Errors) {
    for row in table.rows::<S>().filter(|row| row.numbers[0].sqrt() < LAST) {
        let x = row.numbers[0];
        let c = Stumpff::new(S::lit(x));
        let values = [c.c1, c.c2, c.c3, c.c4, c.c5, c.c6, c.d(), c.e(), c.beta1(), c.beta2()];
        for (k, value) in values.into_iter().enumerate() {
            let (truth, rest) = (row.numbers[1 + 2 * k], row.numbers[2 + 2 * k]);
            // c₁ crosses zero at π; it enters M = c₁I + θc₂[1]× of norm |(c₁, θc₂)|, which does not.
            let scale = if k == 0 { truth.hypot(x.sqrt() * row.numbers[3]) } else { truth.abs() };
            let error = (value.value() - truth) - rest;
            errors.record(BOUNDS[k].name, x.sqrt(), &[S::lit(error)], &[0.0], scale);
        }
    }
}

fn measure<S: Real>() -> Errors {
    let mut errors = Errors::default();
    elementary::<S, S>(|x| x, &mut errors);
    coefficients::<S>(&Table::parse(include_str!("coefficients.csv"), 1), &mut errors);
    plane::<S>(&Table::parse(include_str!("se2.csv"), 13), &mut errors);
    space::<S>(&Table::parse(include_str!("se3.csv"), 23), &mut errors);
    galilean::<S>(&Table::parse(include_str!("sgal3.csv"), 36), &mut errors);
    similarity_of_space::<S>(&Table::parse(include_str!("sim3.csv"), 26), &mut errors);
    similarity_of_the_plane::<S>(&Table::parse(include_str!("sim2.csv"), 16), &mut errors);
    second_order::<S>(&mut errors);
    assert_eq!(errors.0.len(), BOUNDS.len(), "every operation has one bound");
    errors
}

fn assert_bounds(errors: &Errors, scalar: &str) {
    for Bound { name, principal, beyond, .. } in BOUNDS {
        let [below_pi, above_pi] = errors.0[*name];
        assert!(below_pi <= *principal, "{scalar} {name}: {below_pi:.2} ε, promised {principal}");
        assert!(above_pi <= *beyond, "{scalar} {name}: {above_pi:.2} ε beyond π, promised {beyond}");
    }
}

#[test]
fn every_operation_holds_its_stated_bound_in_f64() {
    assert_bounds(&measure::<f64>(), "f64");
}

#[test]
fn every_operation_holds_its_stated_bound_in_f32() {
    assert_bounds(&measure::<f32>(), "f32");
}

#[test]
fn the_accuracy_document_states_these_bounds() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/accuracy.md");
    let (double, single) = (measure::<f64>(), measure::<f32>());
    let mut text = String::from(PREAMBLE);
    let committed = std::fs::read_to_string(path).unwrap_or_default();
    let bless = std::env::var_os("BOXPLUS_BLESS").is_some();
    for Bound { name, relative_to, principal, beyond } in BOUNDS {
        let (double, single) = (double.0[*name], single.0[*name]);
        let mut promise = format!("| {name} | {relative_to} | {principal} |");
        let mut measured = format!(" {:.1} | {:.1} |", double[0], single[0]);
        if *beyond == NONE {
            promise += " – |";
            measured += " – | – |";
        } else {
            write!(promise, " {beyond} |").unwrap();
            write!(measured, " {:.1} | {:.1} |", double[1], single[1]).unwrap();
        }
        let stated = committed.lines().any(|l| l.starts_with(&promise));
        assert!(bless || stated, "docs/accuracy.md lacks {promise:?}; run with BOXPLUS_BLESS=1");
        writeln!(text, "{promise}{measured}").unwrap();
    }
    if bless {
        std::fs::write(path, text).unwrap();
    }
}

const PREAMBLE: &str = "\
# Accuracy of every `lie` operation in f32 and f64

Largest error against arbitrary precision, in units of ε (2⁻²³ in `f32`, 2⁻⁵² in `f64`), over θ from 10⁻¹² to 6.2, both sides
of every switch, π ± 10⁻¹², generic directions and translations from 10⁻⁶ to 10⁶ m. Errors are normwise and block by block:
the norm of the difference over the norm named in the second column, so that a large translation hides nothing. The
bounds are asserted by `cargo test -p boxplus --test reference`, the same for both scalars; this file is written by
`BOXPLUS_BLESS=1 cargo test -p boxplus --test reference`, the tables by `scripts/*_tables.py`.

Beyond π, where no logarithm leads, errors are given in multiples of θ/(2π − θ): c₂ has a double zero at 2π, d, e and the
inverse Jacobians have a pole, and there the rounding of θ² itself is amplified. e enters Q̃ only as e(φ·ρ)φ^².

SE₂(3) has no rows of its own: its position and its velocity are, bit for bit, the translation of SE(3), and so are their
blocks of every Jacobian (`tests/groups`). The same holds of SGal(3) but for its position and the blocks named here, those
of row ρ. Sim(3) and Sim(2) are measured for |σ| ≤ 6, with σ and θ vanishing independently; their rotations are those of SO(3)
and SO(2), and so are those of ℝ⁺×SO(3), ℝ⁺×SO(2) and S³. Other coordinates of rotations and S² state their bounds in
their module docs, held by `tests/rotations`. Names of blocks are those of the module docs.

The elementary functions are the library's own (`lie/elementary.rs`), the angle of a point the platform's: errors in units in the last
place of the result, for |x| up to 65536 (sin, cos) and 708 (exp), next to where the reduced argument vanishes; the same of single
numbers and of those inside a batch. A batch has the bits of single operations at every tangent of these tables (`tests/batch.rs`).

DJ and DJ⁻¹ are the derivatives of J_l and J_l⁻¹ along a direction δ, block by block; those of J_r differ by signs only. They are
sums, one term for each coordinate of δ, which may cancel: relative to the largest of them. So is the block ρφ of SGal(3), the sum
of a term in ρ and one in νι. SE₂(3) is made of the same blocks as SE(3).

| operation | relative to | bound, θ ≤ π | bound, θ > π | f64, θ ≤ π | f32, θ ≤ π | f64, θ > π | f32, θ > π |
|---|---|---|---|---|---|---|---|
";
