//! The parts of a machine: the bus of its disk, its display, its memory, its firmware.
//!
//! Owns QEMU's options for each of them. Never starts a machine.

use std::path::Path;

/// The bus of the disk, as QEMU's devices, the last of which has the node `disk`.
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
    /// A framebuffer of the firmware, without a card that has a driver.
    Ramfb,
    StandardVga,
    Virtio,
    /// The same without the VGA part of a PC.
    VirtioGpu,
    /// A card whose driver is not in the image.
    Vmware,
}

/// The firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Firmware {
    /// It starts any program.
    Plain,
    /// It starts signed programs only, if its variables have keys.
    Secure,
    /// That of an ARM computer; it starts any program.
    Arm64,
}

/// The parts of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Hardware {
    pub(crate) bus: Bus,
    pub(crate) display: Display,
    pub(crate) memory_mib: u32,
    pub(crate) firmware: Firmware,
}

/// The machine of all claims that name no other.
pub(crate) const USUAL: Hardware =
    Hardware { bus: Bus::VirtioBlk, display: Display::Virtio, memory_mib: 1024, firmware: Firmware::Plain };

impl Bus {
    fn devices(self) -> &'static [&'static str] {
        match self {
            // The controller that the machine has by default.
            Self::Ahci => &["ide-hd,bus=ide.0"],
            Self::Nvme => &["nvme,serial=unit"],
            Self::Sd => &["sdhci-pci", "sd-card"],
            Self::Uas => &["usb-uas,id=uas,bus=xhci.0", "scsi-hd,bus=uas.0"],
            // Other USB disks are not started.
            Self::UsbStorage => &["usb-storage,bus=xhci.0,port=2,bootindex=0"],
            Self::VirtioBlk => &["virtio-blk-pci"],
            Self::VirtioScsi => &["virtio-scsi-pci,id=scsi", "scsi-hd,bus=scsi.0"],
        }
    }

    /// The size of the disk in MiB, where the bus needs one: cards have powers of two.
    pub(crate) fn disk_mib(self) -> Option<u64> {
        (self == Self::Sd).then_some(4_096)
    }

    /// Whether Debian's `ovmf` can start from it. It has no driver for QEMU's SD host, and for USB disks the old
    /// protocol only, while QEMU's UAS disk has the new one only; real UAS disks have both.
    pub(crate) fn is_read_by_firmware(self) -> bool {
        !matches!(self, Self::Sd | Self::Uas)
    }

    /// Whether this name in `/sys/block` belongs to it.
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

    /// Whether the picture is copied while it is shown: a framebuffer of the firmware has one buffer, and so has the
    /// driver of `cirrus`.
    pub(crate) fn may_tear(self) -> bool {
        matches!(self, Self::Cirrus | Self::Ramfb | Self::Vmware)
    }
}

impl Firmware {
    /// Its variables as delivered: a secure one has Microsoft's keys.
    pub(crate) fn variables(self) -> &'static Path {
        Path::new(match self {
            Self::Plain => "/usr/share/OVMF/OVMF_VARS_4M.fd",
            Self::Secure => "/usr/share/OVMF/OVMF_VARS_4M.ms.fd",
            Self::Arm64 => "/usr/share/AAVMF/AAVMF_VARS.fd",
        })
    }

    /// QEMU's options for processor and board.
    fn board(self) -> &'static [&'static str] {
        match self {
            Self::Plain => &["-cpu", "max", "-machine", "q35"],
            Self::Secure => {
                &["-cpu", "max", "-machine", "q35,smm=on", "-global", "driver=cfi.pflash01,property=secure,value=on"]
            }
            Self::Arm64 => &["-cpu", "cortex-a72", "-machine", "virt"],
        }
    }

    /// Its file, from Debian's `ovmf` or `qemu-efi-aarch64`.
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

    /// QEMU's options for it. The node `disk` is there already; the firmware's variables come next.
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
