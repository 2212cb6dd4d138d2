//! The GPU that the tests of one program share.

use caustic_device::{Device, DeviceChoice, Error};
use std::io::Write;
use std::sync::OnceLock;

/// The GPU that `CAUSTIC_TEST_GPU` names (as `--device` does; hardware before software if it is not set), or none.
///
/// Without one, a line on stderr says so, past the capture of the test harness, and the test is to return. With
/// `CAUSTIC_REQUIRE_GPU=1`, which CI sets, or where a GPU was named, that is a failure instead.
///
/// # Panics
/// If a GPU is required and there is none.
#[must_use]
pub fn gpu() -> Option<&'static Device> {
    static GPU: OnceLock<Result<Device, String>> = OnceLock::new();
    let named = std::env::var("CAUSTIC_TEST_GPU").ok();
    let opened = GPU.get_or_init(|| {
        let choice: DeviceChoice = named.as_deref().unwrap_or("gpu").parse()?;
        let (device, line) = Device::open(&choice).map_err(|error: Error| error.to_string())?;
        say(&format!("GPU tests run on {line}"));
        Ok(device)
    });
    match opened {
        Ok(device) => Some(device),
        Err(why) => {
            let required = std::env::var("CAUSTIC_REQUIRE_GPU").is_ok_and(|value| value == "1");
            assert!(!required && named.is_none(), "a GPU is required: {why}");
            let thread = std::thread::current();
            say(&format!("SKIPPED: no Vulkan GPU: {} ({why})", thread.name().unwrap_or("a test")));
            None
        }
    }
}

/// Writes a line that the test harness does not capture, as it does what `eprintln!` prints.
fn say(line: &str) {
    // A closed stderr is no reason for a test to fail.
    let _ = writeln!(std::io::stderr(), "{line}");
}
