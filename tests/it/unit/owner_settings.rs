//! The owner's settings.
//!
//! Owns the claims on `dreams-owner`, and on the player and the updater that read what it kept. The keys and values are
//! tried in `crates/settings/src/owner.rs`.

use bundle::ObjectId;
use claims::bundle_maker::rubbish;
use claims::owner::Settings;
use claims::programs::{self, output, succeed};
use claims::unit::Unit;
use claims::web::{Behaviour, WebServer};
use std::fs;
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;
use std::time::SystemTime;

#[test]
fn what_is_right_is_kept_and_what_is_wrong_is_told_and_changes_nothing() {
    let settings = Settings::new();
    assert_eq!(output(&mut settings.taking()).status.code(), Some(0), "there is no file yet");
    let good = "hours = \"08:00-23:00\"\naddress = \"192.0.2.7/24\"\n";
    assert_eq!(settings.set(good), (Some(0), String::new()));
    assert_eq!((settings.read("kept").as_deref(), settings.told()), (Some(good), None));
    let beside = settings.read("kept.kept").unwrap();
    assert!(beside.starts_with("format = 1\n") && beside.contains("address = \"192.0.2.7/24\"\n"), "{beside}");
    assert!(settings.read("wired.conf").unwrap().contains("Address=192.0.2.7/24"));

    let far_too_long = format!("# {}", "x".repeat(70_000));
    for (text, code, said, told) in [
        (
            "unit = \"lobby\"\nhours = \"8-23\"\n",
            2,
            "line 2, key `hours`",
            "line 2: hours is as \"Tue-Sun 08:00-23:00\".",
        ),
        ("hour = 1", 2, "unknown field `hour`", "line 1: unknown key hour. Did you mean hours?"),
        ("unit = \"a\"\nunit = \"b\"\n", 2, "line 2, key `unit`: duplicate key", "line 2: unit is set twice."),
        ("", 2, "it is empty", "is empty."),
        ("\n \r\n\0\0", 2, "it is empty", "is empty."),
        (&far_too_long, 3, "cannot read", "has more than 64 KiB."),
    ] {
        let (exit, error) = settings.set(text);
        assert!(exit == Some(code) && error.contains(said), "{exit:?}: {error}");
        let notice = settings.told().unwrap();
        assert!(notice.contains(told) && notice.contains("The settings before it stay."), "{notice}");
        assert_eq!(settings.read("kept").as_deref(), Some(good));
        assert!(settings.read("wired.conf").is_some(), "the last good network stays");
    }
    assert_eq!(settings.set("unit = \"lobby\"\n").0, Some(0));
    assert_eq!(settings.told(), None, "what was told of it is no longer so");
    assert_eq!(settings.read("wired.conf"), None, "what is no longer set is no longer told");
    assert_eq!(settings.read("name").as_deref(), Some("lobby\n"));
    assert_eq!(settings.set("hours = \"08:00-23:00\"\n").0, Some(0));
    assert_eq!(settings.read("name"), None, "nor is the name");
    assert_eq!(settings.set("unit = \"lobby\"\n").0, Some(0));

    fs::remove_file(settings.path("partition/dreams.toml")).unwrap();
    assert_eq!(output(&mut settings.taking()).status.code(), Some(0));
    assert_eq!(settings.read("kept").as_deref(), Some("unit = \"lobby\"\n"), "a lost file takes no settings away");
}

#[test]
fn a_file_of_another_name_or_encoding_is_named_with_what_to_do_and_takes_no_setting_away() {
    let settings = Settings::new();
    let [plain, text] = ["partition/dreams.toml", "partition/Dreams.toml.TXT"].map(|name| settings.path(name));
    let take_in = || {
        let said = output(&mut settings.taking());
        (said.status.code(), settings.told().unwrap_or_default())
    };
    let good = "unit = \"lobby\"\nwifi = \"Home\"\n";
    assert_eq!(settings.set(good), (Some(0), String::new()));
    for (bytes, told) in [
        (b"\xff\xfeu\0n\0i\0t\0".to_vec(), "is saved as UTF-16. Save it as UTF-8."),
        (b"u\0n\0i\0t\0 \0=\0".to_vec(), "is saved as UTF-16. Save it as UTF-8."),
        (b"unit = \"a\"\n# Z\xfcrich\n".to_vec(), "line 2 has characters that are not UTF-8. Save it as UTF-8."),
    ] {
        fs::write(&plain, bytes).unwrap();
        let (code, notice) = take_in();
        assert!(
            code == Some(2) && notice.contains(told) && notice.contains("The settings before it stay."),
            "{notice}"
        );
        assert!(settings.read("kept").as_deref() == Some(good) && settings.read("wifi.conf").is_some());
    }
    fs::write(&plain, [b"\xef\xbb\xbf", "# Z\u{fc}rich\nunit = \"lobby\"\n".as_bytes()].concat()).unwrap();
    assert_eq!(take_in(), (Some(0), String::new()), "a mark before UTF-8 is none of the owner's business");
    assert_eq!(settings.read("name").as_deref(), Some("lobby\n"));

    fs::write(&text, "unit = \"stairs\"\n").unwrap();
    let (code, notice) = take_in();
    assert!(code == Some(2) && notice.contains("dreams.toml is read, Dreams.toml.TXT beside it is not."), "{notice}");
    assert_eq!(settings.set("unit = \"attic\"\n").0, Some(2));
    assert_eq!(settings.read("name").as_deref(), Some("attic\n"), "the file of the right name is taken in");
    fs::remove_file(&plain).unwrap();
    let (code, notice) = take_in();
    assert!(code == Some(2) && notice.contains("Dreams.toml.TXT is not read. Rename it to dreams.toml."), "{notice}");
    assert_eq!(settings.read("name").as_deref(), Some("attic\n"));
    fs::rename(&text, &plain).unwrap();
    assert_eq!(take_in(), (Some(0), String::new()));
    assert_eq!(settings.read("name").as_deref(), Some("stairs\n"));
    assert_eq!(settings.set("# unit = \"lobby\"\n").0, Some(0));
    assert_eq!(settings.read("name"), None, "comments alone take all settings back");
}

#[test]
fn what_nobody_can_mend_in_the_file_is_told_for_a_moment_only() {
    let settings = Settings::new();
    assert_eq!(settings.set("hours = 8\n").0, Some(2));
    assert!(settings.told().is_some());
    fs::create_dir(settings.path("kept")).unwrap();
    assert_eq!(settings.set("unit = \"lobby\"\n").0, Some(3));
    assert!(settings.read("notice").unwrap().contains("The memory of this frame does not take the settings."));
    assert_eq!(settings.told(), None, "the file is right");
    fs::remove_file(settings.path("partition/dreams.toml")).unwrap();
    fs::create_dir(settings.path("partition/dreams.toml")).unwrap();
    assert_eq!(output(&mut settings.taking()).status.code(), Some(3));
    assert!(settings.read("notice").unwrap().contains("dreams.toml cannot be read."));
    assert_eq!(settings.told(), None, "the disk is to blame");
}

#[test]
fn a_password_is_kept_where_its_user_alone_reads_and_told_nowhere() {
    let settings = Settings::new();
    let text = "unit = \"lobby\"\nwifi = \"Home\"\nwifi_password = \"velvet under\"\ndns = [\"192.0.2.53\"]\n";
    assert_eq!(settings.set(text), (Some(0), String::new()));
    assert!(settings.read("wifi.conf").unwrap().contains("psk=\"velvet under\""));
    let mode = |name: &str| fs::metadata(settings.path(name)).unwrap().permissions().mode() & 0o777;
    assert_eq!((mode("wifi.conf"), mode("kept")), (0o600, 0o640));
    let files = fs::read_dir(settings.path("")).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let holding: Vec<_> =
        files.filter(|name| settings.read(name).is_some_and(|text| text.contains("velvet"))).collect();
    assert_eq!(holding, ["wifi.conf"]);
    assert!(settings.read("kept").unwrap().contains("wifi = \"Home\""), "the rest is for the player and the updater");
    assert!(settings.read("wireless.conf").unwrap().contains("DNS=192.0.2.53"));

    let (exit, error) = settings.set("wifi = \"Home\"\nwifi_password = \"velvet\"\n");
    assert!(exit == Some(2) && error.contains("line 2, key `wifi_password`") && !error.contains("velvet"), "{error}");
    let told = settings.told().unwrap();
    assert!(
        told.contains("line 2: wifi_password is 8 to 63 English letters or signs in \"\".") && !told.contains("velvet"),
        "{told}"
    );
    assert!(settings.read("wifi.conf").unwrap().contains("velvet under"), "the last good Wi-Fi stays");
    let (exit, error) = settings.set("wifi = \"Home\"\nwifi_country = \"Switzerland\"\n");
    assert!(
        exit == Some(2) && error.contains("line 2, key `wifi_country`: `Switzerland` is not a valid country"),
        "{error}"
    );
    assert_eq!(settings.set("unit = \"lobby\"\n").0, Some(0));
    assert_eq!(
        (settings.read("wifi.conf"), settings.read("wireless.conf")),
        (None, None),
        "what is no longer set is gone"
    );
}

#[test]
fn a_unit_restarts_only_in_the_hours_for_it_and_while_no_flock_is_on_trial() {
    let unit = Unit::new();
    let keep = unit.path("owner.toml");
    let system = unit.path("os-release");
    fs::write(&system, "DREAMS_DATE=2026-01-01T00:00:00Z\n").unwrap();
    let may_restart = |hours: &str| {
        fs::write(&keep, format!("hours = \"{hours}\"\ntimezone = \"UTC\"\n")).unwrap();
        let mut owner = Command::new(programs::owner());
        owner.args(["may-restart", "--keep"]).arg(&keep).arg("--flock").arg(unit.path("store/current"));
        output(owner.arg("--system").arg(&system)).status.code()
    };
    // Hours that exclude the present time, and hours that include it.
    fs::write(&keep, "").unwrap();
    let written = fs::metadata(&keep).unwrap().modified().unwrap().duration_since(SystemTime::UNIX_EPOCH).unwrap();
    let now = written.as_secs() / 60 % 1_440;
    let hours = |from: u64, to: u64| {
        let [from, to] = [from, to].map(|minute| minute % 1_440);
        format!("{:02}:{:02}-{:02}:{:02}", from / 60, from % 60, to / 60, to % 60)
    };
    let (dark, lit) = (hours(now + 700, now + 740), hours(now + 1_420, now + 700));
    assert_eq!((may_restart(&dark), may_restart(&lit)), (Some(0), Some(1)), "at minute {now}");
    unit.maker.bundle(&unit.stick(), &rubbish(2, 1_000, 0), &["lobby"], 1);
    assert_eq!(unit.update(&[]).status.code(), Some(0));
    assert_eq!(may_restart(&dark), Some(1), "the flock that has come is on trial");
}

#[test]
fn a_clock_counts_if_it_was_kept_over_the_start_or_a_time_server_has_set_it() {
    let unit = Unit::new();
    let [keep, system, synchronised] = ["owner.toml", "os-release", "synchronized"].map(|name| unit.path(name));
    let shown = |seconds: i64| {
        let mut date = Command::new("date");
        date.arg("--utc").arg(format!("--date={seconds} seconds")).arg("+%FT%TZ");
        String::from_utf8(succeed(&mut date)).unwrap().trim().to_owned()
    };
    let hour = |hours: i64| shown(hours * 3_600).get(11..16).unwrap().to_owned();
    let [dark, lit] = [[10, 11], [-1, 1]].map(|[from, to]| format!("{}-{}", hour(from), hour(to)));
    let up = fs::read_to_string("/proc/uptime").unwrap();
    let up_s: i64 = up.split('.').next().unwrap().parse().unwrap();
    // A unit that does not know the time restarts after a day, whatever the hours are.
    let unknown = [Some(i32::from(up_s < 86_400)); 2];
    let restarts = |made_s: i64| {
        fs::write(&system, format!("ID=dreams\nDREAMS_DATE={}\n", shown(made_s))).unwrap();
        [&dark, &lit].map(|hours| {
            fs::write(&keep, format!("hours = \"{hours}\"\ntimezone = \"UTC\"\n")).unwrap();
            let mut owner = Command::new(programs::owner());
            owner.arg("may-restart").arg("--keep").arg(&keep).arg("--flock").arg(unit.path("store/current"));
            owner.arg("--system").arg(&system).arg("--synchronised").arg(&synchronised);
            output(&mut owner).status.code()
        })
    };
    let (known, before_the_start_s) = ([Some(0), Some(1)], -up_s - 2 * 86_400);
    assert_eq!(restarts(before_the_start_s), known, "the clock was later when the machine started");
    assert_eq!(restarts(-up_s - 60), unknown, "a dead clock that was moved on to the system's date");
    assert_eq!(restarts(-60), unknown, "a dead clock that was moved on to an older date");
    fs::write(&synchronised, "").unwrap();
    assert_eq!([restarts(-up_s - 60), restarts(-60)], [known; 2], "a time server has set it");
    assert_eq!(restarts(86_400), unknown, "to a time before the system was made");
}

#[test]
fn the_updater_goes_by_the_name_and_the_keys_that_the_owner_set() {
    let unit = Unit::new();
    unit.maker.bundle(&unit.stick(), &rubbish(2, 1_000, 0), &["stairs"], 1);
    assert_eq!(unit.update(&[]).status.code(), Some(1), "it is not for this unit");
    let file = fs::read_to_string(unit.maker.keys().join("artist.pub")).unwrap();
    let key = file.lines().nth(1).unwrap();
    let config = config_with(&unit.path("update.toml"), &unit.path("owner.toml"));
    fs::write(unit.path("owner.toml"), format!("unit = \"stairs\"\nkeys = [\"{key}\"]\n")).unwrap();
    let mut update = Command::new(programs::updater());
    update.arg("--config").arg(config).arg("--store").arg(unit.path("store"));
    update.arg("--keys").arg(unit.path("no-such-folder")).arg(unit.stick());
    let said = output(&mut update);
    assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
}

#[test]
fn a_unit_asks_a_new_address_at_its_next_run_and_waits_again_after_it() {
    let (unit, settings) = (Unit::new(), Settings::new());
    unit.maker.bundle(&unit.stick(), &rubbish(2, 1_000, 0), &["lobby"], 1);
    let servers = [(); 2].map(|()| WebServer::serve(&unit.stick(), Behaviour::Good));
    let config = config_with(&unit.path("update.toml"), &settings.path("kept"));
    let runs = |settings_text: &str| {
        assert_eq!(settings.set(settings_text), (Some(0), String::new()));
        // As the timer does, twice.
        for _ in 0..2 {
            let mut update = unit.update_from(None);
            let said = output(update.arg("--config").arg(&config).arg("--schedule").arg(unit.path("schedule")));
            assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
        }
        servers.each_ref().map(|server| server.heard().0.iter().filter(|path| path.ends_with("lobby.seal")).count())
    };
    let [one, other] = servers.each_ref().map(|server| format!("url = \"{}\"\n", server.url()));
    assert_eq!([runs(&one), runs(&one), runs(&other)], [[1, 0], [0, 0], [0, 1]]);
}

#[test]
fn votes_go_by_the_button_that_the_owner_set_and_read_nothing_else_of_the_settings() {
    let settings = Settings::new();
    let buttons = "button = \"any\"\nbutton_down = \"KEY_DOWN\"\nvote_noise = true\n";
    assert_eq!(settings.set(&format!("unit = \"lobby\"\nwifi = \"Home\"\n{buttons}")), (Some(0), String::new()));
    let told = settings.read("votes.toml").unwrap();
    assert!(told.contains("button = \"any\"") && !told.contains("lobby") && !told.contains("Home"), "{told}");
    let mode = fs::metadata(settings.path("votes.toml")).unwrap().permissions().mode() & 0o777;
    assert_eq!(mode, 0o644, "the user of the votes is in no group of the unit's others");
    assert_eq!(settings.set("button = \"pedal\"\n").0, Some(2));
    assert_eq!(settings.read("votes.toml"), Some(told), "the last good one stays");
    assert_eq!(settings.set("unit = \"lobby\"\n").0, Some(0));
    assert_eq!(settings.read("votes.toml"), None, "nothing is counted any more");
}

#[test]
fn an_older_system_keeps_the_settings_in_force_that_a_newer_one_took_in() {
    let settings = Settings::new();
    let artist = Unit::new();
    let file = fs::read_to_string(artist.maker.keys().join("artist.pub")).unwrap();
    let key = file.lines().nth(1).unwrap();
    let proxy = TcpListener::bind("127.0.0.1:0").unwrap();
    let hours = "hours = \"00:00-00:01\"\ntimezone = \"UTC\"\n";
    let known = format!(
        "unit = \"stairs\"\nkeys = [\"{key}\"]\naddress = \"192.0.2.7/24\"\n{hours}button = \"any\"\n\
         url = \"http://unit.invalid/flocks\"\nproxy = \"http://{}\"\n",
        proxy.local_addr().unwrap()
    );
    let newer = format!("{known}colour = \"warm\"\nnight = \"dusk\"\n[picture]\nlevels = [7]\nrotate = 7\n");
    let resolved = format!("format = 1\nof = \"{}\"\n{newer}", ObjectId::of(known.as_bytes()));
    for (kept, beside) in [(&newer, None), (&known, Some(&resolved))] {
        fs::write(settings.path("kept"), kept).unwrap();
        if let Some(text) = beside {
            fs::write(settings.path("kept.kept"), text).unwrap();
        }
        let (exit, error) = settings.set(&newer);
        assert!(exit == Some(2) && error.contains("unknown field `colour`"), "{error}");
        let told = "dreams.toml line 9: unknown key colour. The settings before it stay.";
        assert!(settings.told().unwrap().contains(told), "{:?}", settings.told());
        assert_eq!(settings.read("kept").as_ref(), Some(kept), "and they do");
        assert!(settings.read("wired.conf").unwrap().contains("Address=192.0.2.7/24"));
        assert_eq!(settings.read("name").as_deref(), Some("stairs\n"));
        assert!(settings.read("votes.toml").unwrap().contains("button = \"any\""));

        let unit = Unit::new();
        let mut owner = Command::new(programs::owner());
        owner.args(["may-restart", "--keep"]).arg(settings.path("kept"));
        owner.arg("--flock").arg(unit.path("store/current"));
        assert_eq!(output(&mut owner).status.code(), Some(0), "it is dark");
        artist.maker.bundle(&unit.stick(), &rubbish(2, 1_000, 0), &["stairs"], 1);
        let config = config_with(&unit.path("update.toml"), &settings.path("kept"));
        let update = |source: Option<PathBuf>| {
            let mut update = Command::new(programs::updater());
            update.arg("--config").arg(&config).arg("--store").arg(unit.path("store"));
            output(update.arg("--keys").arg(unit.path("no-such-folder")).args(source))
        };
        let said = update(Some(unit.stick()));
        assert_eq!(said.status.code(), Some(0), "name and key: {}", String::from_utf8_lossy(&said.stderr));
        let asked = thread::scope(|scope| {
            let asked = scope.spawn(|| proxy.accept().map(drop));
            let said = update(None);
            assert_eq!(said.status.code(), Some(3), "{}", String::from_utf8_lossy(&said.stderr));
            asked.join()
        });
        assert!(asked.unwrap().is_ok(), "the proxy is asked");
    }
}

/// A config of the updater that names the kept settings.
fn config_with(path: &Path, owner: &Path) -> PathBuf {
    fs::write(path, format!("owner = \"{}\"\n", owner.display())).unwrap();
    path.to_owned()
}
