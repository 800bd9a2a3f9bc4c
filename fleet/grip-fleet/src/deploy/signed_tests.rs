//! A gripper that wants signatures: what it takes, what it refuses, and the way back that no signature closes.

use super::{ModelId, Models, Offer, Order, Put, Standing, digest};
use grip_session::{model::default_text, signature::ModelKeys};
use std::path::Path;

const KEY: &str = "RWQX4ME9UTGBr9z/nnfFMLox/Beua3vRoZ+aO7nc6TUMmM0TFCAfbnmZ";
const MODEL: &str = include_str!("../../../../crates/grip-session/tests/signed/model.json");
const SIGNATURE: &str =
    include_str!("../../../../crates/grip-session/tests/signed/model.json.minisig");
const BY_OTHER: &str =
    include_str!("../../../../crates/grip-session/tests/signed/other-key.minisig");

fn open(folder: &Path) -> Models {
    let sha256 = digest(default_text().as_bytes());
    Models::open(folder, ModelId { name: "file".to_owned(), sha256 }).unwrap()
}

fn keys() -> ModelKeys {
    ModelKeys::new(&[KEY.to_owned()], false).unwrap()
}

fn offer(name: &str, text: &str) -> Offer {
    Offer::new(name.to_owned(), text.as_bytes().to_vec(), 60)
}

fn obey(models: &mut Models, order: Order) -> Result<Standing, String> {
    models.obey(order, 0, &mut |_: Put<'_>| Ok(0)).map_err(|fault| fault.to_string())
}

/// A model that stays, by the rules of before.
fn accept(models: &mut Models, name: &str, text: &str) {
    obey(models, Order::Take(offer(name, text))).unwrap();
    obey(models, Order::Accept { sha256: digest(text.as_bytes()) }).unwrap();
}

#[test]
fn each_order_with_a_model_that_is_not_signed_is_refused_with_what_to_type() {
    let folder = tempfile::tempdir().unwrap();
    let mut models = open(folder.path()).with_keys(keys());
    let unsigned = "new.json: it is not signed, and model_keys takes signed models only; sign it: `minisign -Sm new.json`";
    let other = "new.json: it is signed with key A1645C1206F7CE7B, which is not in model_keys; add that key";
    let changed = "new.json: its signature is not of this model";
    let spaced = default_text().to_owned() + " ";
    for (text, why) in [
        (spaced.clone(), unsigned),
        (MODEL.to_owned() + BY_OTHER, other),
        (MODEL.to_owned() + " " + SIGNATURE, changed),
    ] {
        for order in [Order::Check, Order::Replay, Order::Shadow, Order::Take] {
            let reason = obey(&mut models, order(offer("new.json", &text))).unwrap_err();
            assert!(reason.starts_with(why), "{reason}");
        }
    }
    let standing = models.standing();
    assert_eq!((standing.in_force.name.as_str(), standing.trial), ("file", None));
    // A signed one is taken, kept as it came, and its signer stands in the history.
    let signed = MODEL.to_owned() + SIGNATURE;
    accept(&mut models, "new.json", &signed);
    let entry = obey(&mut models, Order::History).unwrap().history.remove(0);
    let provenance = entry.signed.unwrap();
    let comment = "trained in hall-2, card sha256:0f1e";
    assert_eq!(
        (provenance.key.as_str(), provenance.comment.as_str()),
        ("AF8131513DC1E017", comment)
    );
    drop(models);
    let kept = folder.path().join(format!("{}.json", digest(signed.as_bytes())));
    assert_eq!(std::fs::read_to_string(kept).unwrap(), signed);
    assert_eq!(open(folder.path()).with_keys(keys()).standing().in_force.name, "new.json");
}

/// A model was accepted before keys were set; then a signed one. The way leads back over both, and the older one may be ordered as well.
#[test]
fn the_way_back_leads_over_models_without_a_signature() {
    let folder = tempfile::tempdir().unwrap();
    let old = default_text().to_owned() + " ";
    accept(&mut open(folder.path()), "old.json", &old);
    let mut models = open(folder.path()).with_keys(keys());
    let mut in_force = Vec::new();
    models.resume("", &mut |put: Put<'_>| {
        let Put::InForce(model) = put else { panic!("{put:?}") };
        in_force.extend(model.map(|model| model.id.name.clone()));
        Ok(0)
    });
    assert_eq!(in_force, ["old.json"], "at the next start");
    let signed = MODEL.to_owned() + SIGNATURE;
    accept(&mut models, "new.json", &signed);
    let back = obey(&mut models, Order::Take(offer("old.json", &old))).unwrap();
    assert_eq!((back.in_force.name.as_str(), back.trial), ("old.json", None));
    accept(&mut models, "new.json", &signed);
    let back = || Order::Back { sha256: None, why: None };
    assert_eq!(obey(&mut models, back()).unwrap().in_force.name, "old.json");
    assert_eq!(obey(&mut models, back()).unwrap().in_force.name, "file");
    // It is a model like any other now.
    let reason = obey(&mut models, Order::Take(offer("old.json", &old))).unwrap_err();
    assert!(reason.starts_with("old.json: it is not signed"), "{reason}");
}
