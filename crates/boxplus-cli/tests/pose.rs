//! The calculator of uncertain poses: numbers, conventions, errors.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{Folder, Run};
use serde_json::Value;

const STEP: &str = "position=[1,0],yaw_deg=30,sigmas=[0.1,0.1,0.02]";
const LEVER: &str = "position=[2,0],yaw=0";

/// Three poses in space, two of them estimates of one; two are correlated.
const POSES: &str = "\
[pose.robot]
position = [1.0, 2.0, 0.5]
yaw_pitch_roll_deg = [30, 20, -10]
sigmas = [0.1, 0.2, 0.3, 0.01, 0.02, 0.03]
[pose.again]
position = [1.0, 2.0, 0.5]
yaw_pitch_roll_deg = [30, 20, -10]
sigmas = [0.1, 0.2, 0.3, 0.01, 0.02, 0.03]
[pose.drone]
position = [-3.0, 1.0, 4.0]
quaternion_xyzw = [0.1, -0.2, 0.3, 0.9]
covariance = [
  [0.02, 0.01, 0, 0, 0, 0.001], [0.01, 0.03, 0, 0, 0, 0], [0, 0, 0.04, 0, 0, 0],
  [0, 0, 0, 0.001, 0, 0], [0, 0, 0, 0, 0.002, 0.0005], [0.001, 0, 0, 0, 0.0005, 0.001],
]
[[correlation]]
of = ['robot', 'again']
covariance = [
  [0.01, 0, 0, 0, 0, 0], [0, 0.04, 0, 0, 0, 0], [0, 0, 0.09, 0, 0, 0],
  [0, 0, 0, 0.0001, 0, 0], [0, 0, 0, 0, 0.0004, 0], [0, 0, 0, 0, 0, 0.0009],
]
";

const CONVENTIONS: [&str; 9] =
    ["boxplus", "gtsam", "manif", "sophus", "lgmath", "barrau", "ros", "ypr", "rpy"];

fn poses() -> Folder {
    Folder::new().with("poses.toml", POSES)
}

fn computed(run: &Run) -> Value {
    assert_eq!(run.code, 0, "{}", run.stderr);
    run.json()
}

fn matrix(document: &Value) -> Vec<f64> {
    let rows = document["covariance"].as_array().unwrap();
    rows.iter().flat_map(|row| row.as_array().unwrap()).map(|x| x.as_f64().unwrap()).collect()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn close(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(x, y)| (x - y).abs() <= 1e-12 * (1.0 + y.abs()))
}

#[test]
fn a_lever_turns_an_uncertain_heading_into_an_uncertain_place() {
    let document =
        computed(&Folder::new().boxplus(&format!("pose compose {STEP} {LEVER} --json --order first")));
    let (heading, lever) = (0.02_f64.powi(2), 2.0);
    // Ad⁻¹ of a lever along x: the sideways error grows by lever·θ.
    let expected =
        [0.01, 0.0, 0.0, 0.0, 0.01 + lever * lever * heading, lever * heading, 0.0, lever * heading, heading];
    assert!(close(&matrix(&document), &expected), "{document}");
    assert_eq!(document["order"], "first");
    let angle = 30_f64.to_radians();
    assert!(close(&numbers(&document["position"]), &[1.0 + 2.0 * angle.cos(), 2.0 * angle.sin()]));
}

#[test]
fn fourth_order_sees_what_second_order_does_not() {
    let word = "position=[1,0],yaw=0,sigmas=[0.1,0.1,0.5]";
    let at = |order| {
        matrix(&computed(
            &Folder::new().boxplus(&format!("pose compose {word} {word} --json --order {order}")),
        ))
    };
    assert!((at("fourth")[0] - at("second")[0]).abs() > 1e-3);
    assert_eq!(at("second"), at("first"));
}

#[test]
fn what_is_printed_can_be_read_again_in_every_convention() {
    let folder = poses();
    let before = computed(&folder.boxplus("pose show drone -f poses.toml --json"));
    for convention in CONVENTIONS {
        for rotation in ["xyzw", "wxyz", "ypr", "vector", "matrix"] {
            let told = folder
                .boxplus(&format!("pose show drone -f poses.toml --to {convention} --rotation {rotation}"));
            assert_eq!(told.code, 0, "{}", told.stderr);
            let back = computed(&folder.boxplus_fed("pose show result -f - --json", told.stdout));
            assert!(close(&matrix(&back), &matrix(&before)), "{convention} {rotation}: {back}");
            assert!(close(&numbers(&back["position"]), &numbers(&before["position"])));
        }
    }
}

#[test]
fn conventions_order_the_rows_and_choose_the_side() {
    let folder = poses();
    let to =
        |options: &str| computed(&folder.boxplus(&format!("pose show robot -f poses.toml --json {options}")));
    assert!(close(&numbers(&to("--to gtsam")["sigmas"]), &[0.01, 0.02, 0.03, 0.1, 0.2, 0.3]));
    assert!(close(&matrix(&to("--to lgmath")), &matrix(&to("--side global"))));
    assert!(!close(&matrix(&to("--to lgmath")), &matrix(&to("--side local"))));
    let (ypr, rpy) = (numbers(&to("--to ypr")["sigmas"]), numbers(&to("--to rpy")["sigmas"]));
    assert_eq!([ypr[3], ypr[4], ypr[5]], [rpy[5], rpy[4], rpy[3]]);
    let given = computed(&folder.boxplus(
        "pose show position=[1,2,3],yaw_pitch_roll=[1,0.3,0.2],sigmas=[1,2,3,0.1,0.2,0.3] --from ypr --to ypr --json",
    ));
    assert!(close(&numbers(&given["sigmas"]), &[1.0, 2.0, 3.0, 0.1, 0.2, 0.3]));
}

#[test]
fn what_two_poses_share_cancels_between_them() {
    let related = computed(&poses().boxplus("pose relate robot again -f poses.toml --json --order second"));
    assert!(numbers(&related["sigmas"]).iter().all(|sigma| sigma.abs() < 1e-7), "{related}");
    let turned = computed(&poses().boxplus("pose relate again robot -f poses.toml --json --order second"));
    assert!(numbers(&turned["sigmas"]).iter().all(|sigma| sigma.abs() < 1e-7), "{turned}");
}

#[test]
fn an_inverse_of_an_inverse_is_the_pose() {
    let folder = poses();
    let once = folder.boxplus("pose invert drone -f poses.toml");
    let twice = computed(&folder.boxplus_fed("pose invert result -f - --json", once.stdout));
    let before = computed(&folder.boxplus("pose show drone -f poses.toml --json"));
    assert!(close(&matrix(&twice), &matrix(&before)));
}

#[test]
fn two_estimates_that_agree_halve_the_variance() {
    let folder = poses().with(
        "other.json",
        r#"{"pose": {"twin": {"position": [1, 2, 0.5],
        "yaw_pitch_roll_deg": [30, 20, -10], "sigmas": [0.1, 0.2, 0.3, 0.01, 0.02, 0.03]}}}"#,
    );
    let fused = computed(&folder.boxplus("pose fuse robot twin -f poses.toml -f other.json --json"));
    let sigmas = numbers(&fused["sigmas"]);
    assert!(close(&sigmas, &[0.1, 0.2, 0.3, 0.01, 0.02, 0.03].map(|x: f64| x / 2_f64.sqrt())), "{fused}");
    assert!(fused["fit"]["chi_squared"].as_f64().unwrap() < 1e-12);
    assert_eq!(fused["fit"]["degrees_of_freedom"], 6);
    let cautious = computed(
        &folder.boxplus("pose fuse robot twin -f poses.toml -f other.json --unknown-correlation --json"),
    );
    assert!(close(&numbers(&cautious["sigmas"]), &[0.1, 0.2, 0.3, 0.01, 0.02, 0.03]), "{cautious}");
}

#[test]
fn two_estimates_that_contradict_each_other_have_a_probability_however_small() {
    // χ² = 2²/(0.1² + 0.1²) = 200 of 3: Q = erfc(√100) + √(400/π)·e⁻¹⁰⁰ = 4.2e-43.
    let estimate = |x: u32| format!("position=[{x},0],yaw=0,sigmas=[0.1,0.1,0.1]");
    let fused = Folder::new().boxplus(&format!("pose fuse {} {} --json", estimate(0), estimate(2)));
    let p = computed(&fused)["fit"]["p_value"].as_f64().unwrap();
    assert!((p / 4.22e-43 - 1.0).abs() < 0.01, "{p:e}");
}

#[test]
fn a_point_seen_with_an_uncertain_heading_comes_closer_on_average() {
    let seen = computed(
        &Folder::new().boxplus("pose act position=[0,0],yaw=0,sigmas=[0,0,0.3] position=[1,0] --json"),
    );
    assert!((numbers(&seen["position"])[0] - (-0.045_f64).exp()).abs() < 2e-5, "{seen}");
    assert_eq!(seen["rotation"], Value::Null);
}

#[test]
fn three_moves_of_a_covariance_differ() {
    let moved = |meaning: &str| {
        let words = "position=[0,0],yaw=0,sigmas=[0.1,0.2,0.05] position=[1,0],yaw=0.6";
        matrix(&computed(&Folder::new().boxplus(&format!("pose move {words} --as {meaning} --json"))))
    };
    let all = ["correction", "body", "transport", "parent"].map(moved);
    assert!((0..4).all(|i| (0..i).all(|j| !close(&all[i], &all[j]))), "{all:?}");
    assert!(
        close(&all[3], &[0.01, 0.0, 0.0, 0.0, 0.04, 0.0, 0.0, 0.0, 0.0025]),
        "a local error does not see its parent"
    );
}

#[test]
fn mistakes_are_named_and_have_their_exit_codes() {
    let folder = poses();
    let cases = [
        ("show nobody -f poses.toml", 2, "`drone`"),
        ("show nobody", 2, "-f"),
        ("show robot -f missing.toml", 3, "missing.toml"),
        ("show position=[1,2],yaww=0", 3, "yaww"),
        ("show position=[1,2]", 3, "rotation is missing"),
        ("show position=[1,2],yaw=0,yaw_deg=0", 3, "more than once"),
        ("show position=[1,2],yaw=0,sigmas=[1,1]", 3, "3 numbers"),
        ("show position=[1,2],yaw=nan", 3, "not finite"),
        ("show position=[1,2],yaw=0,covariance=[[1,2,0],[2,1,0],[0,0,1]]", 3, "variance along"),
        ("show position=[1,2],yaw=0,sigmas=[1,1,1],information=[[1]]", 3, "one of sigmas"),
        ("show position=[1,2,3,4],yaw=0", 3, "2 numbers or 3"),
        ("compose robot position=[1,2],yaw=0 -f poses.toml", 2, "do not mix"),
        ("fuse robot again -f poses.toml", 2, "correlated"),
        ("fuse robot position=[1,2,0],yaw=0 -f poses.toml", 4, "certain"),
        ("show robot -f poses.toml --to ypr --side global", 2, "side"),
        ("show position=[1,2],yaw=0 --to barrau", 2, "in space"),
        (
            "show position=[0,0,0],yaw_pitch_roll_deg=[10,90,0],sigmas=[1,1,1,1,1,1] --to ypr",
            4,
            "gimbal lock",
        ),
        ("act robot drone -f poses.toml", 3, "no rotation"),
    ];
    for (words, code, told) in cases {
        let run = folder.boxplus(&format!("pose {words}"));
        let message = run.stderr.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        assert_eq!(run.code, code, "{words}: {message}");
        assert!(message.contains(told), "{words}: {message}");
        assert!(run.stdout.is_empty(), "{words}: {}", run.stdout);
    }
}

#[test]
fn degrees_for_radians_are_suspected() {
    let run = Folder::new().boxplus("pose show position=[1,2],yaw=90");
    assert!(run.code == 0 && run.stderr.contains("_deg"), "{}", run.stderr);
}
