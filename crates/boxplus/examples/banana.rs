//! Why is my covariance a banana?
//!
//! A robot drives 100 m straight ahead, its heading wandering by 0.03 rad a metre. Nothing is wrong with its odometry, yet the
//! endpoints do not fill an ellipse: they lie on an arc. The errors *are* Gaussian, only not in x and y: they are in the tangent
//! space, and Exp bends them. Ask the bent region, and it holds what it promises.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::lie::{LieGroup, SE2};
use boxplus::uncertainty::{Gaussian, Global, Order};
use nalgebra::{Vector2, vector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let turn = Gaussian::<SE2, 3, Global>::from_sigmas(SE2::identity(), &vector![0.0, 0.0, 0.03])?;
    let metre = Gaussian::certain(SE2::new(vector![1.0, 0.0], 0.0));
    let steps = || (0..100).flat_map(|_| [&turn, &metre]);
    let end = Gaussian::chain(steps(), Order::Fourth);

    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let drive = |rng: &mut ChaCha8Rng| steps().fold(SE2::identity(), |x, step| x.compose(&step.sample(rng)));
    let ends: Vec<SE2> = (0..2000).map(|_| drive(&mut rng)).collect();

    let region = end.region(0.9)?;
    let ellipse = end.act(&vector![0.0, 0.0], Order::First).ellipsoid(0.9)?;
    let inside = ends.iter().map(|x| region.contains(x)).collect::<Result<Vec<_>, _>>()?;
    let share = |count: usize| 100.0 * count as f64 / ends.len() as f64;
    println!("of {} endpoints, promised 90 %:", ends.len());
    println!("  {:5.1} % in the region of the group", share(inside.iter().filter(|held| **held).count()));
    println!(
        "  {:5.1} % in the ellipse of x and y",
        share(ends.iter().filter(|x| ellipse.contains(&x.translation())).count())
    );

    // A position needs the higher orders: exactly, the mean is Σ exp(−jσ²/2) = 97.81 m and σ is 2.49 m ahead, 16.72 m sideways.
    // That one Gaussian spreads too far ahead is the price of one Gaussian: a hundred turns are not one turn and one step.
    for order in [Order::First, Order::Second, Order::Fourth] {
        let position = end.act(&vector![0.0, 0.0], order);
        let (mean, sigmas) = (position.mean().vector(), position.sigmas());
        println!(
            "  position, {order:?} order: mean {:.2} m, σ ahead {:.2} m, sideways {:.2} m",
            mean.x, sigmas.x, sigmas.y
        );
    }
    // The same region; the largest axes of the *local* errors are sideways and ahead.
    let outline = end.to_local().region(0.9)?.curve([0, 1], 400).map(|x| x.translation());
    draw(&ends, &outline.collect::<Vec<_>>());
    Ok(())
}

/// Endpoints as dots, the section of the region as `o`; x runs up from 80 m, y to the left.
fn draw(ends: &[SE2], outline: &[Vector2<f64>]) {
    let mut page = [[' '; 72]; 12];
    let mut mark = |p: &Vector2<f64>, sign: char| {
        let cell = |x: f64| usize::try_from(x.floor() as i64).unwrap_or(usize::MAX);
        let line = page.get_mut(cell((102.0 - p.x) / 1.8));
        if let Some(place) = line.and_then(|line| line.get_mut(cell((50.0 - p.y) * 0.72))) {
            *place = sign;
        }
    };
    ends.iter().for_each(|x| mark(&x.translation(), '.'));
    outline.iter().for_each(|p| mark(p, 'o'));
    page.iter().for_each(|line| println!("{}", line.iter().collect::<String>()));
}
