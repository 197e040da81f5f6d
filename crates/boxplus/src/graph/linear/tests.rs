//! The factorisation against faer's, on random matrices with the blocks of every kind of graph.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::cholesky::{Cholesky, NotPositive};
use super::dissection::{LEAF, separators};
use super::oracle::{Oracle, amd_order, entries};
use super::ordering::minimum_degree;
use super::pattern::Pattern;
use super::symbolic::Symbolic;
use crate::partition::Partition;

type Pairs = Vec<(u32, u32)>;

/// Graphs of every shape: name, number of variables, and which are joined.
fn graphs() -> Vec<(&'static str, usize, Pairs)> {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let grid = |w: u32, h: u32| -> Pairs {
        let at = move |x, y| x + w * y;
        let right = (0..h).flat_map(move |y| (1..w).map(move |x| (at(x - 1, y), at(x, y))));
        right.chain((1..h).flat_map(move |y| (0..w).map(move |x| (at(x, y - 1), at(x, y))))).collect()
    };
    let mut random = |count: u32, edges: usize| -> Pairs {
        let mut pairs: Pairs = (0..edges)
            .map(|_| (rng.random_range(0..count), rng.random_range(0..count)))
            .map(|(a, b)| (a.min(b), a.max(b)))
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    };
    let mut loops: Pairs = (1..120).map(|i| (i - 1, i)).collect();
    loops.extend([(0, 60), (10, 100), (40, 119), (41, 118)]);
    vec![
        ("nothing", 0, vec![]),
        ("one", 1, vec![]),
        ("apart", 7, vec![]),
        ("chain", 50, (1..50).map(|i| (i - 1, i)).collect()),
        ("loops", 120, loops),
        ("tree", 63, (1..63).map(|i| ((i - 1) / 2, i)).collect()),
        ("star", 40, (1..40).map(|i| (0, i)).collect()),
        ("wide star", 900, (1..900).map(|i| (0, i)).collect()),
        ("grid", 144, grid(12, 12)),
        ("long grid", 120, grid(3, 40)),
        ("dense", 14, (0..14).flat_map(|b| (0..b).map(move |a| (a, b))).collect()),
        ("large dense", 45, (0..45).flat_map(|b| (0..b).map(move |a| (a, b))).collect()),
        ("random", 80, random(80, 160)),
        ("sparse", 200, random(200, 150)),
        ("thick", 60, random(60, 600)),
        ("points", 129, points(9, 120)),
    ]
}

/// Cameras in a row, each point seen by two to four of them; many points by the same ones.
fn points(cameras: u32, count: u32) -> Pairs {
    let seen = |point: u32| {
        let (first, views) = (point * 7 % (cameras - 4), 2 + point % 3);
        (0..views).map(move |view| (first + view + view / 2, cameras + point))
    };
    (0..count).flat_map(seen).collect()
}

fn dims(count: usize, kind: usize, rng: &mut ChaCha8Rng) -> Vec<usize> {
    (0..count)
        .map(|_| match kind {
            0 => 1,
            1 => 3,
            2 => 6,
            3 => rng.random_range(2..=3),
            _ => rng.random_range(1..=10),
        })
        .collect()
}

/// A matrix of this pattern that is positive definite, with a condition number of about 10³.
fn positive(pattern: &Pattern, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut matrix: Vec<f64> = (0..pattern.len()).map(|_| rng.random_range(-1.0..1.0)).collect();
    let mut sums = vec![0.1; pattern.size()];
    for (i, j, at) in entries(pattern).filter(|(i, j, _)| i != j) {
        sums[i] += matrix[at].abs();
        sums[j] += matrix[at].abs();
    }
    pattern.diagonal().into_iter().zip(sums).for_each(|(at, sum)| matrix[at] = sum);
    matrix
}

/// The matrix in faer's hands, factorised, if it can be.
fn oracle(pattern: &Pattern, matrix: &[f64]) -> Option<Oracle> {
    let mut oracle = Oracle::new(pattern);
    oracle.read(matrix);
    oracle.factorise().then_some(oracle)
}

fn largest(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |max, x| max.max(x.abs()))
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |max, (a, b)| max.max((a - b).abs()))
}

/// Calls `check` with a matrix of every graph and every kind of dimensions.
fn on_all(mut check: impl FnMut(&str, &Pattern, &[f64], &mut ChaCha8Rng)) {
    for (name, count, pairs) in graphs() {
        for kind in 0..5 {
            let mut rng = ChaCha8Rng::seed_from_u64(kind as u64);
            let pattern = Pattern::new(&dims(count, kind, &mut rng), &pairs).unwrap();
            let matrix = positive(&pattern, &mut rng);
            check(&format!("{name}, kind {kind}"), &pattern, &matrix, &mut rng);
        }
    }
}

fn vector(len: usize, rng: &mut ChaCha8Rng) -> Vec<f64> {
    (0..len).map(|_| rng.random_range(-1.0..1.0)).collect()
}

#[test]
fn solutions_are_those_of_faer_for_one_and_for_many_right_hand_sides() {
    on_all(|name, pattern, matrix, rng| {
        let size = pattern.size();
        let columns = vector(5 * size, rng);
        let mut cholesky = Cholesky::new(pattern).unwrap();
        cholesky.factorise(matrix).unwrap();
        let mut ours = columns.clone();
        cholesky.solve(&mut ours);
        let mut oracle = oracle(pattern, matrix).unwrap();
        for (ours, rhs) in ours.chunks_exact(size.max(1)).zip(columns.chunks_exact(size.max(1))) {
            let mut theirs = rhs.to_vec();
            oracle.solve(&mut theirs);
            // Condition 10³, some 10 roundings deep.
            assert!(distance(ours, &theirs) < 1e-12 * largest(&theirs), "{name}");
        }
    });
}

#[test]
fn the_right_hand_side_carried_along_gives_the_solution_with_damping() {
    on_all(|name, pattern, matrix, rng| {
        let (rhs, weights) = (vector(pattern.size(), rng), vector(pattern.size(), rng));
        let weights: Vec<f64> = weights.iter().map(|w| w.abs()).collect();
        let mut damped = matrix.to_vec();
        pattern.diagonal().into_iter().zip(&weights).for_each(|(at, w)| damped[at] += 0.3 * w);
        let mut cholesky = Cholesky::new(pattern).unwrap();
        cholesky.factorise_with(matrix, (0.3, &weights), &rhs).unwrap();
        let carried = cholesky.solution();
        let mut plain = rhs.clone();
        cholesky.factorise(&damped).unwrap();
        cholesky.solve(&mut plain);
        assert!(distance(&carried, &plain) <= 1e-13 * largest(&plain), "{name}");
    });
}

#[test]
fn a_factor_is_reused_for_other_values_and_leaves_no_trace() {
    on_all(|name, pattern, matrix, rng| {
        let other = positive(pattern, rng);
        let rhs = vector(pattern.size(), rng);
        let mut fresh = Cholesky::new(pattern).unwrap();
        fresh.factorise(matrix).unwrap();
        let mut used = Cholesky::new(pattern).unwrap();
        used.factorise(&other).unwrap();
        used.invert().unwrap();
        let _ = used.factorise(&vec![-1.0; pattern.len()]);
        used.factorise(matrix).unwrap();
        let (mut a, mut b) = (rhs.clone(), rhs);
        fresh.solve(&mut a);
        used.solve(&mut b);
        assert_eq!(a, b, "{name}");
    });
}

#[test]
fn what_is_not_positive_definite_is_refused_as_by_faer() {
    on_all(|name, pattern, matrix, rng| {
        if pattern.size() == 0 {
            return;
        }
        let diagonal = pattern.diagonal();
        let victim = diagonal[rng.random_range(0..diagonal.len())];
        for value in [-1.0, 0.0, f64::NAN] {
            let mut broken = matrix.to_vec();
            broken[victim] = value;
            let refused = Cholesky::new(pattern).unwrap().factorise(&broken);
            assert_eq!(refused, Err(NotPositive), "{name}, {value}");
            assert!(oracle(pattern, &broken).is_none(), "{name}, {value}");
        }
    });
}

#[test]
fn the_selected_inverse_is_the_dense_inverse() {
    on_all(|name, pattern, matrix, _| {
        let size = pattern.size();
        let mut cholesky = Cholesky::new(pattern).unwrap();
        cholesky.factorise(matrix).unwrap();
        assert_eq!(cholesky.inverse_entry(0, 0), None, "{name}");
        cholesky.invert().unwrap();
        let mut dense = vec![0.0; size * size];
        (0..size).for_each(|i| dense[i * (size + 1)] = 1.0);
        cholesky.solve(&mut dense);
        for (i, j, _) in entries(pattern) {
            let (ours, theirs) = (cholesky.inverse_entry(i, j).unwrap(), dense[j * size + i]);
            let scale = (dense[i * (size + 1)] * dense[j * (size + 1)]).sqrt();
            assert!((ours - theirs).abs() < 1e-12 * scale, "{name}: {ours} {theirs}");
            assert_eq!(cholesky.inverse_entry(j, i), Some(ours), "{name}");
        }
    });
}

/// Multiplications of a factorisation of scalars in this order.
fn work(count: usize, pairs: &Pairs, order: &[u32]) -> u64 {
    let mut place = vec![0; count];
    order.iter().enumerate().for_each(|(i, &v)| place[v as usize] = i);
    let mut rows = vec![std::collections::BTreeSet::new(); count];
    for &(a, b) in pairs.iter().filter(|(a, b)| a != b) {
        let (a, b) = (place[a as usize], place[b as usize]);
        rows[a.min(b)].insert(a.max(b));
    }
    let mut work = 0;
    for column in 0..count {
        let below = core::mem::take(&mut rows[column]);
        work += (below.len() as u64 + 1).pow(2);
        if let Some(&parent) = below.iter().next() {
            rows[parent].extend(below.into_iter().skip(1));
        }
    }
    work
}

#[test]
fn orders_are_permutations_that_leave_as_little_fill_as_those_of_amd() {
    let (mut ours, mut theirs) = (0, 0);
    for (name, count, pairs) in graphs() {
        let order = minimum_degree(&vec![1; count], &pairs, &[]);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..count as u32).collect::<Vec<_>>(), "{name}");
        if count > 0 {
            let amd = amd_order(count, &pairs);
            let (one, other) = (work(count, &pairs, &order), work(count, &pairs, &amd));
            assert!(one as f64 <= 1.3 * other as f64, "{name}: {one} against {other}"); // ties fall differently
            ours += one;
            theirs += other;
        }
    }
    assert!(ours as f64 <= 1.05 * theirs as f64, "{ours} against {theirs}");
}

/// A cubic lattice with this many nodes a side.
fn lattice(side: u32) -> Pairs {
    let at = |[x, y, z]: [u32; 3]| x + side * (y + side * z);
    let node = |i: u32| [i % side, i / side % side, i / side / side];
    let mut pairs = vec![];
    for i in 0..side.pow(3) {
        for axis in (0..3).filter(|&axis| node(i)[axis] + 1 < side) {
            let mut next = node(i);
            next[axis] += 1;
            pairs.push((i, at(next)));
        }
    }
    pairs
}

#[test]
fn separators_leave_small_parts_and_go_last() {
    let graphs = graphs().into_iter().map(|(name, count, pairs)| (name, count, pairs, 0));
    let lattice = [("lattice", 1728, lattice(12), 200)];
    for (name, count, pairs, least) in graphs.chain(lattice) {
        let dims = vec![1; count];
        let last = separators(&dims, &pairs);
        assert!(last.len() >= least && 2 * last.len() <= count, "{name}: {} separate", last.len());
        let order = minimum_degree(&dims, &pairs, &last);
        assert_eq!(order[count - last.len()..], last, "{name}");
        let mut sorted = order;
        sorted.sort_unstable();
        assert_eq!(sorted, (0..count as u32).collect::<Vec<_>>(), "{name}");
        if least > 0 {
            let mut parts = Partition::new(count);
            let free = |i: &u32| !last.contains(i);
            for (a, b) in pairs.iter().filter(|(a, b)| free(a) && free(b)) {
                parts.join(*a as usize, *b as usize);
            }
            assert!(parts.parts().all(|(_, size)| size <= LEAF), "{name}");
        }
    }
}

#[test]
fn dissection_saves_a_fifth_of_the_work_in_a_large_lattice_and_is_used_there() {
    let (dims, pairs) = (vec![6; 13824], lattice(24));
    let by_degree = Symbolic::in_order(&dims, &pairs, &minimum_degree(&dims, &pairs, &[]));
    let used = Symbolic::new(&dims, &pairs);
    assert!(used.work <= 0.8 * by_degree.work, "{} against {}", used.work, by_degree.work);
}

#[test]
fn landmarks_are_leaves() {
    // 30 poses in a ring; each of 80 points is seen from four poses in a row.
    let mut dims = vec![6; 30];
    dims.extend([3; 80]);
    let mut pairs: Pairs = (0..30).map(|i| (i, (i + 1) % 30)).collect();
    pairs.extend((0..80u32).flat_map(|point| (0..4).map(move |k| ((point * 7 + k) % 30, 30 + point))));
    let symbolic = Symbolic::new(&dims, &pairs);
    for number in 0..symbolic.parents.len() {
        let (first, end) = (symbolic.starts[number] as usize, symbolic.starts[number + 1] as usize);
        let point = |place: &usize| symbolic.order[*place] >= 30;
        let has_children = symbolic.parents.contains(&(number as u32));
        assert!(!((first..end).all(|place| point(&place)) && has_children), "a point has a child");
        assert!((first..end).skip_while(point).all(|place| !point(&place)), "a pose goes before a point");
    }
}

#[test]
fn points_seen_by_the_same_cameras_go_into_the_reduced_system_together() {
    let mut dims = vec![9; 12];
    dims.extend([3; 300]);
    let pattern = Pattern::new(&dims, &points(12, 300)).unwrap();
    let plan = Cholesky::new(&pattern).unwrap().plan;
    let leaves = plan.fronts.iter().filter(|front| front.is_leaf).count();
    assert!(2 * leaves > 300, "{leaves}"); // the others are merged into a camera, where that costs less
    let groups: Vec<_> = plan.fronts.iter().flat_map(|front| plan.leaves_of(front)).collect();
    assert_eq!(groups.iter().map(|group| group.count as usize).sum::<usize>(), leaves);
    // Points begin at one of 8 cameras and are seen by 2, 3 or 4; a camera may be a leaf, too.
    assert!(groups.len() <= 8 * 3 + 12, "{}", groups.len());
}

#[test]
fn a_factorisation_allocates_nothing() {
    let counted = allocation_counter::measure(|| drop(std::hint::black_box(vec![0.0; 9])));
    assert!(counted.count_total > 0, "allocations are counted");
    on_all(|name, pattern, matrix, rng| {
        let (rhs, weights) = (vector(pattern.size(), rng), vec![1.0; pattern.size()]);
        let mut cholesky = Cholesky::new(pattern).unwrap();
        let mut x = rhs.clone();
        let allocated = allocation_counter::measure(|| {
            cholesky.factorise_with(matrix, (0.1, &weights), &rhs).unwrap();
            cholesky.solve(&mut x);
        });
        assert_eq!(allocated.count_total, 0, "{name}");
    });
}

#[cfg(feature = "parallel")]
#[test]
fn no_bit_depends_on_the_number_of_threads() {
    let at = |x: u32, y: u32| x + 40 * y;
    let mut grid: Pairs = (0..40).flat_map(|y| (1..40).map(move |x| (at(x - 1, y), at(x, y)))).collect();
    grid.extend((1..40).flat_map(|y| (0..40).map(move |x| (at(x, y - 1), at(x, y)))));
    let mut dims = vec![9; 30];
    dims.extend([3; 2000]);
    for (dims, pairs) in [(vec![6; 1600], grid), (dims, points(30, 2000))] {
        for_any_number_of_threads(&Pattern::new(&dims, &pairs).unwrap());
    }
}

#[cfg(feature = "parallel")]
fn for_any_number_of_threads(pattern: &Pattern) {
    use crate::pool::Pool;
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let matrix = positive(pattern, &mut rng);
    let (rhs, zeros) = (vector(pattern.size(), &mut rng), vec![0.0; pattern.size()]);
    let solve = |threads: usize| {
        let mut cholesky = Cholesky::new(pattern).unwrap();
        cholesky.share(std::sync::Arc::new(Pool::new(threads, 1000))).unwrap();
        cholesky.factorise_with(&matrix, (0.0, &zeros), &rhs).unwrap();
        let solution = cholesky.solution();
        cholesky.invert().unwrap();
        let diagonal = (0..pattern.size()).map(|i| cholesky.inverse_entry(i, i).unwrap());
        let bits: Vec<u64> = diagonal.chain(solution).map(f64::to_bits).collect();
        let mut broken = matrix.clone();
        broken[pattern.diagonal()[0]] = -1.0;
        assert_eq!(cholesky.factorise(&broken), Err(NotPositive));
        bits
    };
    let one = solve(1);
    for threads in 2..6 {
        assert_eq!(solve(threads), one, "{threads} threads");
    }
}
