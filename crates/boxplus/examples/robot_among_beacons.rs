//! Where is my robot, and how sure is it?
//!
//! It drives a circle, counts its wheels' turns, and every second sees one of three beacons, sometimes wrongly. Printed are its
//! error and three standard deviations, across its heading and along; the truth should be inside nearly always.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::filter::{DifferentialDrive, Ekf, Filter, Gate, Motion, Outcome, RangeBearing, WheelTravel};
use boxplus::lie::{Action, Rn, SE2};
use boxplus::uncertainty::Gaussian;
use nalgebra::{Vector2, vector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

const BEACONS: [Vector2<f64>; 3] = [vector![8.0, 0.0], vector![-5.0, 6.0], vector![-4.0, -7.0]];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let robot = DifferentialDrive { track: 0.4, rolling: 0.01, slip: 0.005 };
    let sensor = Gaussian::<Rn<2>, 2>::from_sigmas(Rn::new(vector![0.0, 0.0]), &vector![0.05, 0.02])?;
    let filter = Ekf::iterated().gated(Gate::at(0.999));

    // Put down somewhere near (5, 0), facing up, give or take half a metre and half a radian.
    let mut belief = Gaussian::<SE2, 3>::from_sigmas(
        SE2::new(vector![5.0, 0.0], std::f64::consts::FRAC_PI_2),
        &vector![0.5, 0.5, 0.5],
    )?;
    let mut truth = belief.sample(&mut rng);
    let (mut inside, mut gated) = (0, 0);
    println!("  t      x      y    | error and 3σ ahead,  sideways (m),  of heading (°)");
    for second in 1..=60 {
        for _ in 0..10 {
            // The wheels turn by what is read, the robot moves by a little more or less.
            let travel = WheelTravel { left: 0.048, right: 0.052 };
            let slip = Gaussian::<Rn<3>, 3>::new(Rn::new(vector![0.0, 0.0, 0.0]), robot.noise(&travel));
            truth = robot.step(&truth, &travel, &slip.sample(&mut rng).vector());
            belief = filter.predict(&belief, &robot, &travel)?;
        }
        let beacon = BEACONS[second % 3];
        let seen = truth.act_inverse(&beacon);
        let error = sensor.sample(&mut rng).vector();
        // Every tenth second somebody stands before the beacon.
        let shortened = if second % 10 == 0 { 0.5 } else { 1.0 };
        let measured = vector![seen.norm() * shortened, seen.y.atan2(seen.x)] + error;
        let update = filter.update(&belief, &RangeBearing { beacon, measured, noise: *sensor.covariance() });
        belief = update.belief;
        gated += usize::from(matches!(update.outcome, Outcome::Gated(_)));

        let (error, band) = (belief.error_of(&truth), belief.sigmas() * 3.0);
        inside += (0..3).filter(|&i| error[i].abs() <= band[i]).count();
        if second <= 5 || second % 10 == 0 {
            let place = belief.mean().translation();
            print!("{second:3} s {:6.2} {:6.2}  |", place.x, place.y);
            let degrees = [1.0, 1.0, 180.0 / std::f64::consts::PI];
            let column = |i: usize| format!(" {:6.3} ±{:5.3} ", error[i] * degrees[i], band[i] * degrees[i]);
            println!("{}", (0..3).map(column).collect::<String>());
        }
    }
    let share = 100.0 * f64::from(u32::try_from(inside)?) / 180.0;
    println!(
        "{share:.1} % of the errors within 3σ (a Gaussian: 99.7 %); {gated} measurements of 60 not believed"
    );
    Ok(())
}
