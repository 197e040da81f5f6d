//! SE(3) without the standard library and without an allocator, one C function an operation: what `scripts/no_std` links and
//! looks into.
#![no_std]

use boxplus::lie::{Action, LieGroup, SE3};
use nalgebra::{Matrix6, Vector3, Vector6};

use boxplus::nalgebra;

/// Required of every program without the standard library; `scripts/no_std` shows that the operations never get here.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

macro_rules! operations {
    ($scalar:ty: $exp:ident $log:ident $compose:ident $act:ident $rminus_jac:ident) => {
        #[unsafe(no_mangle)]
        pub extern "C" fn $exp(tau: &Vector6<$scalar>, out: &mut SE3<$scalar>) {
            *out = SE3::exp(tau);
        }
        #[unsafe(no_mangle)]
        pub extern "C" fn $log(x: &SE3<$scalar>, out: &mut Vector6<$scalar>) {
            *out = x.log();
        }
        #[unsafe(no_mangle)]
        pub extern "C" fn $compose(x: &SE3<$scalar>, y: &SE3<$scalar>, out: &mut SE3<$scalar>) {
            *out = x.compose(y);
        }
        #[unsafe(no_mangle)]
        pub extern "C" fn $act(x: &SE3<$scalar>, p: &Vector3<$scalar>, out: &mut Vector3<$scalar>) {
            *out = x.act(p);
        }
        #[unsafe(no_mangle)]
        pub extern "C" fn $rminus_jac(
            y: &SE3<$scalar>,
            x: &SE3<$scalar>,
            out: &mut Vector6<$scalar>,
            jacobians: &mut [Matrix6<$scalar>; 2],
        ) {
            let (tau, d_y, d_x) = y.rminus_jac(x);
            (*out, *jacobians) = (tau, [d_y, d_x]);
        }
    };
}

operations!(f64: se3_exp_f64 se3_log_f64 se3_compose_f64 se3_act_f64 se3_rminus_jac_f64);
operations!(f32: se3_exp_f32 se3_log_f32 se3_compose_f32 se3_act_f32 se3_rminus_jac_f32);

/// The control: an index that only the caller knows. The script must find the panic that this one can reach.
#[unsafe(no_mangle)]
pub extern "C" fn control_that_panics(numbers: &[f64; 4], i: usize) -> f64 {
    numbers[i]
}
