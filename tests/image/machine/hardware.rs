//! What a machine is made of: how its disk hangs on it, its display, its memory.
//!
//! Owns QEMU's words for each of them. Never starts a machine.

use std::path::Path;

/// Where the disk hangs: as QEMU's devices, the last of which takes the node `disk`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bus {
    Ahci,
    Nvme,
    Sd,
    Uas,
    UsbStorage,
    VirtioBlk,
    VirtioScsi,
}

/// The display, by QEMU's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Display {
    Bochs,
    Cirrus,
    None,
    Qxl,
    /// A framebuffer of the firmware's, and no card that a driver could be for.
    Ramfb,
    StandardVga,
    Virtio,
    /// The same without what a PC's has besides.
    VirtioGpu,
    /// A card whose driver is not in the image.
    Vmware,
}

/// What starts the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Firmware {
    /// It starts whatever is there.
    Plain,
    /// It starts what is signed with a key that it knows, if it knows any; its variables hold these.
    Secure,
    /// That of a computer with an ARM processor; it starts whatever is there.
    Arm64,
}

/// A machine's parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Hardware {
    pub(crate) bus: Bus,
    pub(crate) display: Display,
    pub(crate) memory_mib: u32,
    pub(crate) firmware: Firmware,
}

/// What the claims of other files are tried on.
pub(crate) const USUAL: Hardware =
    Hardware { bus: Bus::VirtioBlk, display: Display::Virtio, memory_mib: 1024, firmware: Firmware::Plain };

impl Bus {
    fn devices(self) -> &'static [&'static str] {
        match self {
            // The one that the machine has anyhow.
            Self::Ahci => &["ide-hd,bus=ide.0"],
            Self::Nvme => &["nvme,serial=unit"],
            Self::Sd => &["sdhci-pci", "sd-card"],
            Self::Uas => &["usb-uas,id=uas,bus=xhci.0", "scsi-hd,bus=uas.0"],
            // What else is on USB is not started.
            Self::UsbStorage => &["usb-storage,bus=xhci.0,port=2,bootindex=0"],
            Self::VirtioBlk => &["virtio-blk-pci"],
            Self::VirtioScsi => &["virtio-scsi-pci,id=scsi", "scsi-hd,bus=scsi.0"],
        }
    }

    /// How large a disk it takes, in MiB, if not any: cards are powers of two.
    pub(crate) fn disk_mib(self) -> Option<u64> {
        (self == Self::Sd).then_some(4_096)
    }

    /// Whether the firmware of Debian's `ovmf` reads it. It has no driver for QEMU's SD host, and of USB disks it knows the
    /// older protocol only, QEMU's UAS disk the newer one only; UAS disks that one can buy know both.
    pub(crate) fn is_read_by_firmware(self) -> bool {
        !matches!(self, Self::Sd | Self::Uas)
    }

    /// Whether the kernel calls it so, of the names in `/sys/block`.
    pub(crate) fn is_called(self, name: &str) -> bool {
        let beginning = match self {
            Self::Ahci | Self::Uas | Self::UsbStorage | Self::VirtioScsi => "sd",
            Self::Nvme => "nvme",
            Self::Sd => "mmcblk",
            Self::VirtioBlk => "vd",
        };
        name.starts_with(beginning)
    }
}

impl Display {
    fn device(self) -> Option<&'static str> {
        match self {
            Self::Bochs => Some("bochs-display,xres=1280,yres=720"),
            Self::Cirrus => Some("cirrus-vga"),
            Self::None => None,
            Self::Qxl => Some("qxl-vga,xres=1280,yres=720"),
            Self::Ramfb => Some("ramfb"),
            Self::StandardVga => Some("VGA,xres=1280,yres=720"),
            Self::Virtio => Some("virtio-vga,xres=1280,yres=720"),
            Self::Vmware => Some("vmware-svga"),
            Self::VirtioGpu => Some("virtio-gpu-pci,xres=1280,yres=720"),
        }
    }

    /// Whether what is shown is a copy, made while it is shown: a framebuffer of the firmware's has one buffer, and so has
    /// the driver of `cirrus`.
    pub(crate) fn may_tear(self) -> bool {
        matches!(self, Self::Cirrus | Self::Ramfb | Self::Vmware)
    }
}

impl Firmware {
    /// Its variables as they leave the factory: one that is secure knows Microsoft's keys.
    pub(crate) fn variables(self) -> &'static Path {
        Path::new(match self {
            Self::Plain => "/usr/share/OVMF/OVMF_VARS_4M.fd",
            Self::Secure => "/usr/share/OVMF/OVMF_VARS_4M.ms.fd",
            Self::Arm64 => "/usr/share/AAVMF/AAVMF_VARS.fd",
        })
    }

    /// QEMU's words for the processor and the rest of the board.
    fn board(self) -> &'static [&'static str] {
        match self {
            Self::Plain => &["-cpu", "max", "-machine", "q35"],
            Self::Secure => {
                &["-cpu", "max", "-machine", "q35,smm=on", "-global", "driver=cfi.pflash01,property=secure,value=on"]
            }
            Self::Arm64 => &["-cpu", "cortex-a72", "-machine", "virt"],
        }
    }

    /// Where it lies: it is Debian's `ovmf`, or `qemu-efi-aarch64`.
    fn code(self) -> &'static str {
        match self {
            Self::Plain => "/usr/share/OVMF/OVMF_CODE_4M.fd",
            Self::Secure => "/usr/share/OVMF/OVMF_CODE_4M.secboot.fd",
            Self::Arm64 => "/usr/share/AAVMF/AAVMF_CODE.fd",
        }
    }
}

impl Hardware {
    /// The QEMU that emulates it.
    pub(crate) fn program(self) -> &'static str {
        match self.firmware {
            Firmware::Plain | Firmware::Secure => "qemu-system-x86_64",
            Firmware::Arm64 => "qemu-system-aarch64",
        }
    }

    /// QEMU's words for it. The node `disk` is there already; the firmware's variables come next.
    pub(crate) fn words(self) -> Vec<String> {
        let mut words: Vec<_> = self.firmware.board().iter().map(|&word| word.to_owned()).collect();
        let code = format!("if=pflash,format=raw,readonly=on,file={}", self.firmware.code());
        words.extend(["-drive".to_owned(), code]);
        words.extend(["-m".to_owned(), self.memory_mib.to_string()]);
        let mut device = |device: &str| words.extend(["-device".to_owned(), device.to_owned()]);
        device("qemu-xhci,id=xhci");
        let (last, others) = self.bus.devices().split_last().expect("a disk is a device");
        for other in others {
            device(other);
        }
        device(&format!("{last},drive=disk"));
        // The firmware knows the disk by its place on the bus, which is the same whatever display there is.
        self.display.device().into_iter().for_each(&mut device);
        words
    }
}
