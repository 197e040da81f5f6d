#![allow(dead_code)]
mod draw;
mod text;
fn main() {}
#[cfg(test)]
mod scratch {
    use crate::draw::*;
    use nalgebra::Vector3;
    #[test]
    fn pictures() {
        for name in ["sphere2500", "intel", "manhattanOlson3500", "parking-garage", "tinyGrid3D","M3500", "torus3D"] {
            let text = std::fs::read_to_string(format!("/tmp/pic/{name}.g2o")).unwrap();
            let mut p = std::collections::BTreeMap::new();
            let mut e = vec![];
            let mut spatial = false;
            for l in text.lines() {
                let w: Vec<&str> = l.split_ascii_whitespace().collect();
                let f = |i: usize| w[i].parse::<f64>().unwrap();
                match w[0] {
                    "VERTEX_SE3:QUAT" => { spatial = true; p.insert(f(1) as u64, Vector3::new(f(2), f(3), f(4))); }
                    "VERTEX_SE2" => { p.insert(f(1) as u64, Vector3::new(f(2), f(3), 0.0)); }
                    t if t.starts_with("EDGE") => e.push((f(1) as u64, f(2) as u64)),
                    _ => {}
                }
            }
            let loops = e.iter().filter(|(a, b)| a.abs_diff(*b) > 1)
                .map(|(a, b)| Link { ends: [p[a], p[b]], residual: 0.02 * ((a * 7919 + b * 31) % 10007) as f64 }).collect::<Vec<_>>();
            let n = (p.len(), e.len());
            let scene = Scene { spatial, tracks: vec![p.values().copied().collect()], loops, ..Scene::default() };
            let panel = |h: &str, note: &str| Panel { heading: h.into(), note: note.into(), scene: scene.clone() };
            let fig = Figure { title: name.into(), facts: format!("{} poses · {} edges · cost 1.27×10⁶ → 675.701 in 7 iterations, 0.31 s", n.0, n.1), panels: vec![panel("Before", "cost 1.27×10⁶"), panel("After", "cost 675.701")] };
            let svg = fig.svg();
            std::fs::write(format!("/tmp/pic/{name}.svg"), &svg).unwrap();
            let t = std::time::Instant::now();
            std::fs::write(format!("/tmp/pic/{name}.png"), png(&svg).unwrap()).unwrap();
            println!("{name} {} {:?}", svg.len(), t.elapsed());
        }
    }
}
