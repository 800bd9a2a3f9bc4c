use super::{Backoff, Finder, UsbFilter, Wanted, glob};
use crate::{Places, PortError};
use core::time::Duration;
use grip_sim::Pty;
use std::{
    fs::{create_dir_all, remove_dir_all, remove_file, write},
    os::unix::fs::symlink,
    path::Path,
};
use tempfile::TempDir;

const BAUD: u32 = 2_000_000;

/// A tree like that of the system, in which pseudo-terminals are the devices.
struct Tree {
    folder: TempDir,
    places: Places,
}

/// A USB device as the kernel shows it.
struct Device<'a> {
    name: &'a str,
    socket: &'a str,
    pid: u16,
    serial: Option<&'a str>,
}

const GRIPPER: Device<'_> =
    Device { name: "ttyACM0", socket: "1-2", pid: 0x0043, serial: Some("GRIP-0042") };

impl Tree {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let places = Places::under(folder.path());
        for path in [&places.dev, &places.class_tty, &places.by_id] {
            create_dir_all(path).unwrap();
        }
        create_dir_all(places.class_tty.join("tty0")).unwrap();
        Self { folder, places }
    }

    fn plug(&self, device: &Device<'_>) -> Pty {
        let pty = Pty::open(None).unwrap();
        let Device { name, socket, pid, serial } = device;
        let usb = self.folder.path().join("sys/devices/usb1").join(socket);
        let interface = usb.join(format!("{socket}:1.0"));
        create_dir_all(interface.join("tty").join(name)).unwrap();
        let mut facts = vec![
            ("idVendor", "2341".to_owned()),
            ("idProduct", format!("{pid:04x}")),
            ("product", "Slip gripper".to_owned()),
            ("speed", "12".to_owned()),
        ];
        facts.extend(serial.map(|serial| ("serial", serial.to_owned())));
        for (file, value) in facts {
            write(usb.join(file), format!("{value}\n")).unwrap();
        }
        write(interface.join("bInterfaceNumber"), "00\n").unwrap();
        let class = self.places.class_tty.join(name);
        create_dir_all(&class).unwrap();
        symlink(&interface, class.join("device")).unwrap();
        symlink(pty.port(), self.places.dev.join(name)).unwrap();
        if let Some(serial) = serial {
            let link = self.places.by_id.join(format!("usb-Slip_gripper_{serial}-if00"));
            symlink(format!("../../{name}"), link).unwrap();
        }
        pty
    }

    fn unplug(&self, device: &Device<'_>) {
        remove_dir_all(self.places.class_tty.join(device.name)).unwrap();
        remove_dir_all(self.folder.path().join("sys/devices/usb1").join(device.socket)).unwrap();
        remove_file(self.places.dev.join(device.name)).unwrap();
        remove_dir_all(&self.places.by_id).unwrap();
        create_dir_all(&self.places.by_id).unwrap();
    }

    fn auto(&self, filter: UsbFilter) -> Finder {
        Finder::new(self.places.clone(), Wanted::Auto(filter))
    }

    fn named(&self, path: &Path) -> Finder {
        Finder::new(self.places.clone(), Wanted::Path(path.to_owned()))
    }
}

#[test]
fn ports_are_described_as_the_kernel_and_udev_know_them() {
    let tree = Tree::new();
    let _pty = tree.plug(&GRIPPER);
    write(tree.places.class_tty.join("tty0/type"), "0\n").unwrap();
    let ports = tree.places.ports().unwrap();
    let [port] = ports.as_slice() else { panic!("{ports:?}") };
    assert_eq!(port.path, tree.places.dev.join("ttyACM0"));
    assert!(port.by_id.as_ref().unwrap().ends_with("usb-Slip_gripper_GRIP-0042-if00"));
    let usb = port.usb.as_ref().unwrap();
    assert_eq!((usb.vid, usb.pid, usb.interface), (0x2341, 0x0043, Some(0)));
    assert_eq!((usb.socket.as_str(), usb.speed_mbit), ("1-2", Some(12.0)));
    assert_eq!(usb.serial.as_deref(), Some("GRIP-0042"));
    let link = port.by_id.clone().unwrap();
    assert_eq!(tree.places.name_of(&link).as_deref(), Some("ttyACM0"));
    assert_eq!(tree.places.look_up(&link).as_ref(), Some(port));
    assert_eq!(tree.places.name_of(Path::new("/dev/null")), None);
}

#[test]
fn auto_takes_the_only_port_that_fits_and_lists_several() {
    let tree = Tree::new();
    let error = tree.auto(UsbFilter::default()).find().unwrap_err();
    assert!(matches!(error, PortError::Absent(_)) && error.is_temporary(), "{error}");
    assert!(error.to_string().contains("plug the gripper in"), "{error}");
    let _first = tree.plug(&GRIPPER);
    let found = tree.auto(UsbFilter::default()).find().unwrap();
    assert_eq!(found, tree.places.dev.join("ttyACM0"));
    let twin = Device { name: "ttyACM1", socket: "1-3", serial: None, ..GRIPPER };
    let _second = tree.plug(&twin);
    let error = tree.auto(UsbFilter::default()).find().unwrap_err();
    assert!(matches!(error, PortError::Argument(_)));
    assert!(!error.is_temporary());
    let text = error.to_string();
    for word in ["2 USB", "ttyACM0", "ttyACM1", "GRIP-0042", "no serial number", "socket 1-3"] {
        assert!(text.contains(word), "no {word:?} in {text}");
    }
}

#[test]
fn the_filter_of_the_configuration_decides() {
    let tree = Tree::new();
    let _first = tree.plug(&GRIPPER);
    let other = Device { name: "ttyUSB0", socket: "1-3", pid: 0x6001, serial: Some("FT-7") };
    let _second = tree.plug(&other);
    let fits = |filter: UsbFilter| tree.auto(filter).find().map(|path| path.ends_with("ttyACM0"));
    let serial = |pattern: &str| UsbFilter { serial: Some(pattern.into()), ..UsbFilter::default() };
    assert!(fits(UsbFilter { pid: Some(0x0043), ..UsbFilter::default() }).unwrap());
    assert!(!fits(UsbFilter { pid: Some(0x6001), ..UsbFilter::default() }).unwrap());
    assert!(fits(serial("GRIP-*")).unwrap());
    assert!(!fits(serial("FT-7")).unwrap());
    assert!(fits(UsbFilter { product: Some("*grip*".into()), ..serial("G*2") }).unwrap());
    let error = fits(UsbFilter { vid: Some(0x1234), ..serial("x") }).unwrap_err().to_string();
    for word in ["none of the 2", "vid 0x1234", "serial x", "gripctl ports"] {
        assert!(error.contains(word), "no {word:?} in {error}");
    }
}

#[test]
fn a_device_that_comes_back_is_found_under_another_name_and_in_another_socket() {
    let tree = Tree::new();
    for by_name in [true, false] {
        let pty = tree.plug(&GRIPPER);
        let mut finder = if by_name {
            tree.named(&tree.places.dev.join("ttyACM0"))
        } else {
            tree.auto(UsbFilter::default())
        };
        drop(finder.open(BAUD).unwrap());
        assert_eq!(finder.chosen().unwrap().serial.as_deref(), Some("GRIP-0042"));
        tree.unplug(&GRIPPER);
        drop(pty);
        assert!(finder.find().unwrap_err().is_temporary());
        let moved = Device { name: "ttyACM1", socket: "1-4", ..GRIPPER };
        let pty = tree.plug(&moved);
        assert_eq!(finder.find().unwrap(), tree.places.dev.join("ttyACM1"));
        assert!(finder.open(BAUD).is_ok());
        tree.unplug(&moved);
        drop(pty);
    }
}

#[test]
fn a_stranger_at_the_old_name_is_left_alone() {
    let tree = Tree::new();
    let path = tree.places.dev.join("ttyACM0");
    let strangers = [
        Device { serial: Some("GRIP-0043"), ..GRIPPER },
        Device { pid: 0x0036, ..GRIPPER },
        Device { serial: None, ..GRIPPER },
    ];
    for stranger in &strangers {
        let mut finders = [tree.named(&path), tree.auto(UsbFilter::default())];
        let pty = tree.plug(&GRIPPER);
        for finder in &mut finders {
            drop(finder.open(BAUD).unwrap());
        }
        tree.unplug(&GRIPPER);
        drop(pty);
        let _pty = tree.plug(stranger);
        for finder in &mut finders {
            let error = finder.open(BAUD).unwrap_err();
            assert!(matches!(error, PortError::Absent(_)), "{error}");
            assert!(error.to_string().contains("GRIP-0042"), "{error}");
        }
        tree.unplug(stranger);
    }
}

#[test]
fn twins_without_serial_numbers_are_reported_by_their_sockets() {
    let tree = Tree::new();
    let ours = Device { serial: None, ..GRIPPER };
    let twin = Device { name: "ttyACM1", socket: "1-3", serial: None, ..GRIPPER };
    let path = tree.places.dev.join("ttyACM0");
    let (mut named, mut auto) = (tree.named(&path), tree.auto(UsbFilter::default()));
    let first = tree.plug(&ours);
    drop(named.open(BAUD).unwrap());
    drop(auto.open(BAUD).unwrap());
    tree.unplug(&ours);
    drop(first);
    let _twin = tree.plug(&twin);
    assert!(named.find().is_err() && auto.find().is_err(), "the twin is not ours");
    let back = Device { name: "ttyACM2", ..ours };
    let again = tree.plug(&back);
    assert!(named.find().unwrap().ends_with("ttyACM2"));
    assert!(auto.find().unwrap().ends_with("ttyACM2"));
    tree.unplug(&back);
    drop(again);
    // In a third socket only the name that the user gave can state that it is ours.
    let moved = Device { socket: "1-7", ..ours };
    let _moved = tree.plug(&moved);
    assert_eq!(named.find().unwrap(), path);
    assert!(auto.find().is_err());
}

#[test]
fn a_port_without_usb_is_known_by_its_path() {
    let tree = Tree::new();
    let folder = tree.folder.path();
    let link = folder.join("gripper");
    let mut finder = tree.named(&link);
    for _ in 0..3 {
        let error = finder.open(BAUD).unwrap_err();
        assert!(matches!(error, PortError::Open { .. }) && error.is_temporary(), "{error}");
        let _pty = Pty::open(Some(&link)).unwrap();
        assert!(finder.open(BAUD).is_ok());
        assert!(finder.chosen().is_none());
    }
}

#[test]
fn patterns() {
    for (pattern, text) in
        [("", ""), ("*", ""), ("a*c", "abc"), ("*b*", "abc"), ("a*b*c", "a-b-b-c")]
    {
        assert!(glob(pattern, text), "{pattern} {text}");
    }
    for (pattern, text) in [("", "a"), ("a", "ab"), ("a*a", "a"), ("*b", "abc"), ("a*c*b", "acd")] {
        assert!(!glob(pattern, text), "{pattern} {text}");
    }
}

#[test]
fn pauses_grow_to_two_seconds_and_start_again() {
    let mut backoff = Backoff::default();
    let pauses: Vec<u128> = (0..8).map(|_| backoff.pause().as_millis()).collect();
    assert_eq!(pauses, [50, 100, 200, 400, 800, 1600, 2000, 2000]);
    backoff.reset();
    assert_eq!(backoff.pause(), Duration::from_millis(50));
    let mut slow = Backoff::new(Duration::from_millis(250), Duration::from_secs(5));
    let pauses: Vec<u128> = (0..7).map(|_| slow.pause().as_millis()).collect();
    assert_eq!(pauses, [250, 500, 1000, 2000, 4000, 5000, 5000]);
    slow.reset();
    assert_eq!(slow.pause(), Duration::from_millis(250));
}
