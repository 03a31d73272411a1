//! Drivers of the simplest displays: the firmware's framebuffer, and those of virtual machines.
//!
//! Owns simpledrm, which stands for efidrm and vesadrm as well; virtio-gpu; bochs, which stands for qxl, cirrus, ast and
//! mgag200. None has vblanks, nor anything to set but the picture.
//!
//! Sources: Linux 6.12: `drivers/gpu/drm/tiny/simpledrm.c` (`simpledrm_primary_plane_helper_atomic_update`: a window that does
//! not begin at the first row is accepted and not copied), `drivers/gpu/drm/tiny/bochs.c` (`bochs_plane_update`: the window is
//! ignored), `drivers/gpu/drm/virtio/virtgpu_plane.c`, `drm_atomic_helper.c` (`drm_atomic_helper_fake_vblank`).

use super::{CORE, IN_FORMATS};
use crate::kms::scripted::family::{Family, Limits, Window};
use crate::paint::Format;

const LIMITS: Limits = Limits {
    formats: &[Format::Xr24],
    has_modifiers: true,
    pitch: 1,
    largest: (4096, 4096),
    shrinks: 0,
    must_cover: true,
    turns_linear: false,
    window: Window::Ignored,
    ramps: &[],
    waits_to_dim: false,
    has_vblanks: false,
    fastest_khz: u32::MAX,
    has_one_mode: false,
};

pub(crate) const SIMPLEDRM: Family = Family {
    driver: "simpledrm",
    about: "the firmware's framebuffer",
    connector: "Unknown-1",
    rows: &[CORE, &[IN_FORMATS]],
    limits: Limits { has_one_mode: true, ..LIMITS },
    has_overlay: false,
};

pub(crate) const VIRTIO_GPU: Family = Family {
    driver: "virtio_gpu",
    about: "a virtual machine's virtio display",
    connector: "Virtual-1",
    rows: &[CORE],
    limits: Limits { has_modifiers: false, largest: (8192, 8192), window: Window::Moves, ..LIMITS },
    has_overlay: false,
};

pub(crate) const BOCHS: Family = Family {
    driver: "bochs-drm",
    about: "a virtual machine's standard VGA",
    connector: "Virtual-1",
    rows: &[CORE],
    limits: Limits { has_modifiers: false, largest: (8192, 8192), ..LIMITS },
    has_overlay: false,
};
