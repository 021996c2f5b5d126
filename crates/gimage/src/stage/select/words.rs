//! The role that a name tells: words that artists use for garments, bodies and props.

use super::Role;

const CLOTH: &str = "apron blouse cape capelet cloak cloth clothes clothing coat dress fabric flag garment gown hoodie \
    jacket jeans jumper kilt kimono leggings outfit overall pants poncho robe sari sash scarf shawl shirt shorts skirt \
    sleeve surcoat sweater tabard top tights trousers trouser tunic veil vest waistcoat";

const BODY: &str = "arm arms beard body brow brows cornea ear ears eye eyeball eyebrow eyebrows eyelash eyelashes eyes \
    face feet finger fingers foot gum gums hair hand hands head iris jaw leg legs lips moustache mouth nail nails neck \
    nose pupil sclera skin skull tail teeth toe toes tongue tooth torso";

const RIGID: &str = "amulet armor armour arrow axe backpack badge bag bandolier belt blade bomb book boot boots bow bracer \
    bracers brooch buckle button buttons cap clip crossbow crown cuirass dagger earring earrings flask footwear gauntlet \
    gauntlets glasses glove gloves goggles greave greaves gun hammer hat helm helmet holster horn horns jewel jewelry \
    lantern mask mug necklace pauldron pauldrons pendant pistol pouch pumpkin quiver rifle ring sandal sandals satchel \
    scabbard sheath shield shoe shoes sneakers socket spear spellbook staff stick sword wand weapon zip zipper";

/// Shortest word for cloth that is also found at the end of a longer one, as `dress` in `nightdress`.
const SHORTEST_ENDING: usize = 4;

/// Words for rigid parts that are also found there. Others end ordinary words, as `ring` in `drawstring` and `tail` in `detail`.
const RIGID_ENDINGS: &str = "armor armour book boots gloves shoes sword";

/// The role that the last word of a name with a known meaning tells, and that word. Words end at digits, marks and
/// capital letters: `Wolf3D_OutfitTop` is wolf, d, outfit, top. The last one counts, as in `Body_Armor`, but a word for cloth
/// before one for a body, as in `Shirt_Body`: the garment's part that covers it.
pub(super) fn role(name: &str) -> Option<(Role, String)> {
    let mut told = words(name).into_iter().rev().filter_map(|word| meaning(&word).map(|role| (role, word)));
    let last = told.next()?;
    match last.0 {
        Role::Body => Some(told.find(|(role, _)| *role == Role::Cloth).unwrap_or(last)),
        _ => Some(last),
    }
}

fn meaning(word: &str) -> Option<Role> {
    let lists = [(CLOTH, Role::Cloth), (BODY, Role::Body), (RIGID, Role::Rigid)];
    let exact = lists.iter().find(|(list, _)| list.split_whitespace().any(|known| known == word));
    // The longest ending: `nightdress` ends in `dress`.
    let ending = || {
        let cloth = CLOTH.split_whitespace().filter(|known| known.len() >= SHORTEST_ENDING).map(|w| (w, Role::Cloth));
        let known = cloth.chain(RIGID_ENDINGS.split_whitespace().map(|w| (w, Role::Rigid)));
        let ends = known.filter(|(known, _)| word.ends_with(known));
        ends.max_by_key(|(known, _)| known.len()).map(|(_, role)| role)
    };
    exact.map(|(_, role)| *role).or_else(ending)
}

fn words(name: &str) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    let (mut open, mut was_lower) = (false, false);
    for c in name.chars() {
        if !c.is_alphabetic() {
            open = false;
            continue;
        }
        if c.is_uppercase() && was_lower {
            open = false;
        }
        was_lower = c.is_lowercase();
        match out.last_mut().filter(|_| open) {
            Some(word) => word.extend(c.to_lowercase()),
            None => out.push(c.to_lowercase().collect()),
        }
        open = true;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_roles() {
        for (name, is) in [
            ("Mage_Cape", Some(Role::Cloth)),
            ("Wolf3D_Outfit_Top", Some(Role::Cloth)),
            ("Wolf3D_Outfit_Footwear", Some(Role::Rigid)),
            ("tshirt1900", Some(Role::Cloth)),
            ("EyeLeft", Some(Role::Body)),
            ("Mage_ArmRight", Some(Role::Body)),
            ("Body_Armor", Some(Role::Rigid)),
            ("Spellbook_open", Some(Role::Rigid)),
            ("1H_Wand", Some(Role::Rigid)),
            ("SkirtLining", Some(Role::Cloth)),
            ("mage_texture", None),
            ("default001_A_0", None),
            ("charm", None),
            ("nightdress", Some(Role::Cloth)),
            ("Coat_Detail", Some(Role::Cloth)),
            ("Cape_Surface", Some(Role::Cloth)),
            ("Dress_String", Some(Role::Cloth)),
            ("Hood_Drawstring", None),
            ("Chair", None),
            ("Shirt_Body", Some(Role::Cloth)),
            ("Shirt_Button", Some(Role::Rigid)),
            ("", None),
        ] {
            assert_eq!(role(name).map(|r| r.0), is, "{name}");
        }
        assert_eq!(words("Wolf3D_OutfitTop"), ["wolf", "d", "outfit", "top"]);
    }
}
