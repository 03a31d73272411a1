//! What the unit files promise the appliance.
//!
//! Owns the claims about `systemd/`: that systemd understands every line, that little of the machine lies open to the
//! services, and that a stick is mounted as something that strangers bring. Services are judged with their drop-ins, as
//! systemd merges them. Never starts a service: the image's tests do.
//!
//! Start at [`judge`].

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// systemd's own measure of what lies open to a service: 0 nothing, 100 everything. It calls up to 19 `OK`.
const EXPOSED_AT_MOST: &str = "15";
/// The same for the service that sets up a radio: that is the machine's network.
const RADIO_EXPOSED_AT_MOST: &str = "19";
/// Keys that systemd knows since 254; Debian 12 has 252, reads over them, and restarts at an even pace.
const YOUNG_KEYS: [&str; 2] = ["RestartSteps", "RestartMaxDelaySec"];
/// Services without a sandbox: they mount, partition, or start other units as root. Each replaces the common drop-in.
const OPEN: [&str; 5] = ["bench", "data", "good", "journal", "rest"];
/// What a service may do though the common drop-in forbids it, by systemd's names of its checks.
const EXCEPTIONS: [(&str, &str); 4] = [
    ("dreams-name.service", "ProtectHostname"),
    ("dreams-name.service", "ProtectKernelTunables"),
    ("dreams-player.service", "SystemCallFilter_resources"),
    ("dreams-wifi@.service", "CapabilityBoundingSet_CAP_NET_ADMIN"),
];
/// Where unit files and drop-ins lie on a unit, and where those are that only the image has.
const UNITS: &str = "/usr/lib/systemd/system/";
const IMAGE_UNITS: &str = "image-build/system/usr/lib/systemd/system/";

/// The drop-ins of services by their place below [`UNITS`]: those of the list, and those that only the image has.
fn drop_ins() -> BTreeMap<String, String> {
    let rows = super::layout::layout().into_iter();
    let listed = rows.filter_map(|row| Some((row.to.strip_prefix(UNITS)?.to_owned(), super::read(&row.from))));
    let confs = super::files(".conf").into_iter();
    let of_image = confs.filter_map(|(path, text)| Some((path.strip_prefix(IMAGE_UNITS)?.to_owned(), text)));
    listed.chain(of_image).filter(|(place, _)| place.contains(".service.d/")).collect()
}

/// Runs `systemd-analyze` with `arguments` on the unit file `text` of the name `name`, beside these drop-ins. The programs
/// of the unit file need not be installed: `/bin/true` stands in for each.
fn analyze(name: &str, text: &str, drop_ins: &BTreeMap<String, String>, arguments: &[&str]) -> Output {
    let folder = tempfile::tempdir().unwrap();
    for (place, text) in drop_ins {
        let path = folder.path().join(place);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    let path = laid(folder.path(), name, text);
    Command::new("systemd-analyze").args(arguments).arg(&path).output().expect("systemd-analyze starts")
}

/// What `systemd-analyze` with `arguments` finds wrong with the unit file `text` of the name `name`; empty if nothing.
fn judge(name: &str, text: &str, arguments: &[&str]) -> String {
    let output = analyze(name, text, &drop_ins(), arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    let mut faults: String = said.lines().filter(|line| !is_young(line)).collect();
    if !output.status.success() {
        faults.push_str(&String::from_utf8(output.stdout).unwrap());
    }
    faults
}

/// Whether the unit file at `path` is one of [`OPEN`].
fn is_open(path: &str) -> bool {
    OPEN.iter().any(|open| path.ends_with(&format!("/dreams-{open}.service")))
}

/// systemd's checks of the service `name`, merged with `drop_ins`, that fail: by their names.
fn open_checks(name: &str, text: &str, drop_ins: &BTreeMap<String, String>) -> BTreeSet<String> {
    let output = analyze(name, text, drop_ins, &["security", "--offline=true", "--no-pager", "--json=short"]);
    let checks: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
    let open = checks.iter().filter(|check| check["set"] == false);
    open.map(|check| check["json_field"].as_str().unwrap().to_owned()).collect()
}

/// The same for a timer or a path, beside the service that it calls.
fn judge_timer(name: &str, text: &str, service: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = match service.split_once('@') {
        Some((template, _)) => format!("{template}@.service"),
        None => service.to_owned(),
    };
    let services = super::files(".service");
    let found = services.iter().find(|(path, _)| path.ends_with(&format!("/{file}")));
    let (_, text_of_called) = found.unwrap_or_else(|| panic!("`{name}` calls `{service}`, which is not there"));
    let called = laid(folder.path(), &file, text_of_called);
    let timer = laid(folder.path(), name, text);
    let output =
        Command::new("systemd-analyze").args(["verify", "--man=no"]).arg(&timer).arg(&called).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    said.lines().filter(|line| !is_young(line)).collect()
}

/// Whether `line` complains of a key that this systemd is too old for.
fn is_young(line: &str) -> bool {
    YOUNG_KEYS.iter().any(|key| line.contains(&format!("Unknown key '{key}'")))
}

/// Lays a unit file into `folder`, with `/bin/true` for its programs.
fn laid(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    let line = |line: &str| match line.split_once("/usr/bin/dreams-") {
        Some((key, _)) if key.starts_with("Exec") => format!("{key}/bin/true\n"),
        Some(_) | None => format!("{line}\n"),
    };
    fs::write(&path, text.lines().map(line).collect::<String>()).unwrap();
    path
}

fn player() -> String {
    super::read("systemd/dreams-player.service")
}

#[test]
fn systemd_understands_every_line_of_every_service() {
    for (path, text) in super::files(".service") {
        let name = path.rsplit('/').next().unwrap();
        assert_eq!(judge(name, &text, &["verify", "--man=no"]), "", "`{path}`");
    }
    for ending in [".timer", ".path"] {
        for (path, text) in super::files(ending) {
            let name = path.rsplit('/').next().unwrap();
            let named = text.lines().find_map(|line| line.strip_prefix("Unit="));
            let service = named.map_or_else(|| name.replace(ending, ".service"), str::to_owned);
            assert_eq!(judge_timer(name, &text, &service), "", "`{path}`");
        }
    }
    let misspelt = player().replace("WatchdogSec", "WatchdogSecs");
    assert!(judge("dreams-player.service", &misspelt, &["verify", "--man=no"]).contains("WatchdogSecs"));
}

#[test]
fn a_stick_is_mounted_as_what_strangers_bring_and_starts_the_service_that_there_is() {
    let rules = super::read("systemd/80-dreams-update.rules");
    assert!(rules.contains("ENV{SYSTEMD_WANTS}+=\"dreams-update@%k.service\""));
    // ext4 only where an installer has allowed it, since its driver trusts the file system.
    for wanted in [
        "ENV{ID_FS_TYPE}!=\"vfat|exfat|ext4\", GOTO=",
        "ENV{ID_FS_TYPE}==\"ext4\", IMPORT{file}=\"/etc/dreams/sticks.conf\"",
        "ENV{ID_FS_TYPE}==\"ext4\", ENV{STICKS}!=\"*ext4*\", GOTO=",
    ] {
        assert!(rules.contains(wanted), "{wanted}");
    }
    assert!(super::read("config/sticks.conf").lines().any(|line| line == "STICKS=vfat,exfat"));
    // Rules are run in the order of their names.
    let layout = super::read("systemd/layout");
    let ours = layout.split_whitespace().filter_map(|word| word.strip_prefix("/usr/lib/udev/rules.d/"));
    assert!(
        ours.clone().count() == super::files(".rules").len()
            && ours.clone().all(|name| name > "60-persistent-storage.rules"),
        "what is on it is known"
    );
    let text = super::read("systemd/dreams-update@.service");
    assert!(rules.contains("ENV{SYSTEMD_WANTS}+=\"dreams-settings@%k.service\""));
    let mounts: Vec<&str> = text.lines().filter(|line| line.contains("/usr/bin/mount ")).collect();
    let options = "-t ${STICKS} -o ro,nosuid,nodev,noexec,nosymfollow,errors=remount-ro ";
    let [mount] = mounts[..] else { panic!("one mount: {mounts:?}") };
    assert!(mount.contains(options), "{mount}");
    assert!(text.contains("\nEnvironment=STICKS=vfat,exfat\nEnvironmentFile=-/etc/dreams/sticks.conf\n"));
    assert!(text.contains("BindsTo=dev-%i.device") && text.contains("PrivateNetwork=yes"));
    // Both services mount the same stick: with the same options, and the second for another user than the player's.
    let settings = super::read("systemd/dreams-settings@.service");
    let mount = mount.replace("/run/dreams-mounts/%i", "/run/dreams-mounts/settings-%i");
    assert!(settings.lines().any(|line| line == mount) && settings.contains("\nUser=dreams-net\n"), "{mount}");
    assert!(settings.contains("BindsTo=dev-%i.device") && settings.contains("PrivateNetwork=yes"));
    // So is what else can be pulled out and written to elsewhere.
    for (path, types) in
        [("systemd/dreams-owner@.service", "vfat"), ("image-build/system/usr/bin/dreams-log", "vfat,exfat")]
    {
        let options = format!("-t {types} -o ro,nosuid,nodev,noexec,nosymfollow,errors=remount-ro,uid=");
        assert!(super::read(path).contains(&options), "`{path}`");
    }
}

#[test]
fn a_unit_waits_for_its_display() {
    let wanted = "ExecStart=/usr/bin/dreams-player --config /etc/dreams/player.toml --screen kms";
    assert!(player().lines().any(|line| line == wanted));
}

#[test]
fn the_player_waits_for_nothing_that_a_picture_does_not_need() {
    let text = player();
    let wants = |key: &str| text.lines().filter_map(|line| line.strip_prefix(key)).collect::<Vec<_>>();
    assert_eq!(wants("After="), ["var-lib-dreams.mount", "modprobe@drm.service"], "and these may fail");
    assert_eq!(wants("Wants="), ["modprobe@drm.service"], "at once, and without it if need be");
    for key in ["Requires=", "BindsTo=", "Requisite=", "RequiresMountsFor="] {
        assert_eq!(wants(key), [""; 0], "`{key}`");
    }
    // Each of these asks for disks, or for all that a system usually has before a service.
    for key in ["StateDirectory=", "CacheDirectory=", "LogsDirectory=", "PrivateTmp="] {
        assert_eq!(wants(key), [""; 0], "`{key}`");
    }
    assert_eq!(wants("DefaultDependencies="), ["no"]);
    assert_eq!(wants("WantedBy="), ["sysinit.target"]);
}

#[test]
fn a_still_picture_takes_over_from_a_player_that_fails_and_gives_way_to_it_again() {
    let has = |text: &str, wanted: &str| text.lines().any(|line| line == wanted);
    assert!(has(&player(), "OnFailure=dreams-still.service") && has(&player(), "Restart=always"));
    assert!(has(&player(), "StartLimitIntervalSec=3min") && has(&player(), "StartLimitBurst=6"));
    let still = super::read("systemd/dreams-still.service");
    for wanted in [
        "ExecStart=/usr/bin/dreams-player --still --screen kms",
        "Conflicts=dreams-player.service shutdown.target",
        "After=dreams-player.service modprobe@drm.service",
        "Wants=dreams-again.timer",
        "Restart=always",
        "StartLimitIntervalSec=0",
    ] {
        assert!(has(&still, wanted), "{wanted}");
    }
    let again = super::read("systemd/dreams-again.timer");
    for wanted in ["Unit=dreams-player.service", "OnActiveSec=5min", "PartOf=dreams-still.service"] {
        assert!(has(&again, wanted), "{wanted}");
    }
}

#[test]
fn the_picture_comes_before_whatever_else_the_unit_does() {
    let has = |text: &str, wanted: &str| text.lines().any(|line| line == wanted);
    for wanted in ["OOMScoreAdjust=-900", "MemoryMin=256M", "Slice=dreams.slice", "FileDescriptorStoreMax=1"] {
        assert!(has(&player(), wanted), "{wanted}");
    }
    assert!(has(&super::read("systemd/dreams-still.service"), "Slice=dreams.slice"));
    // Directly below the root slice: protection of memory is limited by that of all slices above.
    for wanted in ["MemoryMin=256M", "CPUWeight=1000", "IOWeight=1000"] {
        assert!(has(&super::read("systemd/dreams.slice"), wanted), "{wanted}");
    }
    for unit in ["dreams-update@.service", "dreams-update.service", "dreams-scrub.service"] {
        let text = super::read(&format!("systemd/{unit}"));
        for wanted in ["OOMScoreAdjust=500", "MemoryMax=256M", "IOWeight=1"] {
            assert!(has(&text, wanted), "{wanted} in {unit}");
        }
        // An update that somebody waits for has a fiftieth of the player's weight; others run only when idle.
        let weight = if unit == "dreams-update@.service" { "CPUWeight=20" } else { "CPUWeight=idle" };
        assert!(has(&text, weight), "{weight} in {unit}");
    }
    // A unit's own system starts with the picture alone, and goes on when it is lit, or will not be.
    let image = |unit: &str| super::read(&format!("image-build/system/usr/lib/systemd/system/{unit}"));
    let first = "Wants=dreams-data.service dreams-player.service dreams-rest.service systemd-journald.socket";
    assert!(has(&image("dreams.target"), first));
    assert!(has(&image("dreams-rest.service"), "After=dreams-curtain.target"));
    assert!(has(&image("dreams-rest.service"), "ExecStart=/usr/bin/systemctl start --no-block multi-user.target"));
    for wanted in ["After=dreams-player.service", "JobTimeoutSec=45", "Before=systemd-journald.service"] {
        assert!(has(&image("dreams-curtain.target"), wanted), "{wanted}");
    }
}

#[test]
fn little_of_the_machine_lies_open_to_a_service() {
    let mut judged = 0;
    for (path, text) in super::files(".service") {
        let name = path.rsplit('/').next().unwrap();
        let most = if name == "dreams-wifi@.service" { RADIO_EXPOSED_AT_MOST } else { EXPOSED_AT_MOST };
        let threshold = format!("--threshold={most}");
        let faults = judge(name, &text, &["security", "--offline=true", "--no-pager", &threshold]);
        assert_eq!(faults.is_empty(), !is_open(&path), "`{path}`: {faults}");
        let [merged, alone] = [drop_ins(), BTreeMap::new()].map(|drop_ins| open_checks(name, &text, &drop_ins));
        assert_eq!(merged == alone, is_open(&path), "the sandbox of `{path}`");
        judged += 1;
    }
    assert!(judged >= 18, "only {judged} services were judged");
    let threshold = format!("--threshold={EXPOSED_AT_MOST}");
    let measure = ["security", "--offline=true", "--no-pager", &threshold];
    assert!(!analyze("dreams-player.service", &player(), &BTreeMap::new(), &measure).status.success());
}

#[test]
fn a_service_may_do_what_the_sandbox_forbids_only_where_it_needs_it() {
    let forbidden: BTreeSet<&str> = EXCEPTIONS.iter().map(|(_, check)| *check).collect();
    let mut found = Vec::new();
    for (path, text) in super::files(".service") {
        let name = path.rsplit('/').next().unwrap().to_owned();
        if !is_open(&path) {
            let open = open_checks(&name, &text, &drop_ins()).into_iter();
            found.extend(open.filter(|check| forbidden.contains(&**check)).map(|check| (name.clone(), check)));
        }
    }
    found.sort();
    assert_eq!(found, EXCEPTIONS.map(|(name, check)| (name.to_owned(), check.to_owned())));
}

#[test]
fn the_sandbox_is_written_once() {
    let sandbox = super::read("systemd/dreams-.service.d/10-sandbox.conf");
    let settings: Vec<&str> = sandbox.lines().filter(|line| line.contains('=') && !line.starts_with('#')).collect();
    assert!(settings.len() >= 20, "only {settings:?} were read");
    for (path, text) in super::files(".service") {
        let again: Vec<_> = text.lines().filter(|line| !is_open(&path) && settings.contains(line)).collect();
        assert!(again.is_empty(), "`{path}` repeats {again:?}");
    }
}

#[test]
fn whoever_has_something_to_tell_people_may_whichever_service_made_the_folder_for_it() {
    let units = super::files(".service");
    let makes = |(_, unit): &&(String, String)| {
        let folders = unit.lines().filter_map(|line| line.strip_prefix("RuntimeDirectory="));
        folders.flat_map(str::split_whitespace).any(|folder| folder == "dreams-update")
    };
    let making: Vec<_> = units.iter().filter(makes).collect();
    assert!(making.len() >= 4, "only {} services were read", making.len());
    // The group may write: the owner's service has another user.
    let lacks: Vec<_> = making.iter().filter(|(_, unit)| !unit.contains("\nRuntimeDirectoryMode=0775\n")).collect();
    assert!(lacks.is_empty(), "{lacks:?}");
}

#[test]
fn services_that_write_to_partitions_have_other_users_than_the_player_and_no_raw_disk() {
    let units = super::files(".service");
    let writing: Vec<_> = units.iter().filter(|(_, unit)| unit.contains("\nDeviceAllow=block-* rwm\n")).collect();
    assert!(writing.len() >= 3, "only {} services were read", writing.len());
    for (path, unit) in &units {
        let has_disks = unit.lines().any(|line| line.starts_with("SupplementaryGroups=") && line.contains("disk"));
        // One that installs starts from its own stick alone, and nothing else of a unit starts there.
        let installs = unit.lines().any(|line| line == "ConditionKernelCommandLine=dreams.install");
        assert_eq!(has_disks, installs, "{path}");
    }
    for (path, unit) in writing {
        let user = unit.lines().find_map(|line| line.strip_prefix("User="));
        assert!(user.is_some_and(|user| user != "dreams"), "{path}: {user:?}");
    }
}

#[test]
fn whoever_starts_the_prelude_makes_the_folder_where_it_hands_over_and_passes_its_words_on() {
    let early = super::read("image-build/system/usr/bin/dreams-early");
    let handover = super::read("player/dreams-player/startup/handover.rs");
    let socket = handover.split_once("SOCKET: &str = \"").and_then(|(_, rest)| rest.split_once('"')).unwrap().0;
    let folder = socket.rsplit_once('/').unwrap().0;
    for wanted in [format!("mkdir -m 750 {folder}\n"), format!("chown dreams:dreams {folder}\n")] {
        assert!(early.contains(&wanted), "{wanted}");
    }
    let prelude = super::read("player/dreams-player/startup/prelude.rs");
    let word = prelude.split_once("write_all(b\"").and_then(|(_, rest)| rest.split_once("\\n\"")).unwrap().0;
    let told = early.replace("$lit", word);
    let measured = super::read("tests/image/starts/boot_time.rs");
    let words: Vec<_> = measured.split('"').filter(|text| text.starts_with("dreams: ") && text.len() > 8).collect();
    assert!(words.len() >= 4, "only {words:?} were read");
    for word in words {
        assert!(told.contains(&format!("echo \"{word}\"")), "{word}");
    }
}

#[test]
fn the_documents_know_how_large_the_log_of_a_unit_may_be() {
    let conf = super::read("systemd/image/journal.conf");
    let size = conf.lines().find_map(|line| line.strip_prefix("SystemMaxUse=")?.strip_suffix('M')).unwrap();
    for document in ["image-build/README.md", "CHANGELOG.md"] {
        assert!(super::read(document).contains(&format!("in at most {size} MB of th")), "`{document}`");
    }
}
