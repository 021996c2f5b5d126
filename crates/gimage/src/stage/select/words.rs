//! The role that a name tells: words that artists use for garments, bodies and props.

use super::Role;

const CLOTH: &str = "apron blazer blouse bodice bodysuit bottoms cape capelet cardigan cloak cloth clothes clothing coat corset cowl dress \
    fabric flag frock garment gown hakama haori hood hoodie jacket jeans jumper kilt kimono leggings mantle obi onepiece outfit overall pants \
    parka poncho robe sari sarong sash scarf shawl shirt shorts skirt sleeve smock stocking stockings suit surcoat sweater swimsuit tabard \
    tie tights toga top tops trousers trouser tunic uniform veil vest waistcoat yukata";

/// Words for cloth that tell the kind of a material, and not which garment it is.
const FABRICS: &str = "cloth clothes clothing fabric";

const BODY: &str = "antler antlers arm arms beak beard body brow brows claw claws cornea ear ears eye eyeball eyebrow eyebrows eyelash eyelashes eyes \
    face feet finger fingers foot gum gums hair hand hands head hoof hooves iris jaw leg legs lips mane moustache mouth muzzle nail nails neck \
    nose paw paws pupil sclera skin skull tail teeth toe toes tongue tooth torso";

const RIGID: &str = "amulet armor armour arrow axe backpack badge bag bandolier belt blade bomb book boot boots bow bracer \
    bracers brooch buckle button buttons cap clip crossbow crown cuirass dagger earring earrings flask footwear gauntlet \
    gauntlets glasses glove gloves goggles greave greaves gun hammer hat helm helmet holster horn horns jewel jewelry \
    lantern mask mug necklace pauldron pauldrons pendant pistol pouch pumpkin quiver rifle ring sandal sandals satchel \
    scabbard sheath shield shoe shoes sneakers socket spear spellbook staff stick sword wand weapon zip zipper";

/// Words of joints that move hands and faces, and no garment but gloves and masks.
const BARE: &str = "eye eyes finger fingers index jaw pinky thumb";

/// Words of joints that a garment has some of, and a character all: a hood follows the head, sleeves follow hands, and a robe follows feet.
const ENDS: [&str; 3] = ["head heads headfront headend", "hand hands wrist wrists", "feet foot toe toebase toes"];

/// Parts of a body that garments cover, so that a garment's part has such a name too. A head below a hood is a head.
const COVERED: &str = "arm arms body leg legs neck torso";

/// Words for cloth that also tell a place: the top of a skull is a skull.
const PLACES: &str = "bottoms top tops";

/// Shoes and gloves, of cloth or not.
const WORN: &str = "boot boots footwear glove gloves sandal sandals shoe shoes sneakers";

/// Shortest word for cloth that is also found at the end of a longer one, as `dress` in `nightdress`.
const SHORTEST_ENDING: usize = 4;

/// Words for rigid parts that are also found there. Others end ordinary words, as `ring` in `drawstring` and `tail` in `detail`.
const RIGID_ENDINGS: &str = "armor armour book boots gloves shoes sword";

/// The role that the last word of a name with a known meaning tells, and that word. Words end at digits, marks and
/// capital letters: `Wolf3D_OutfitTop` is wolf, d, outfit, top. The last one counts, as in `Body_Armor`, but a word for cloth
/// before one for a body that it covers, as in `Shirt_Body`: the garment's part there. The top of a skull is a skull. A shoe of cloth, as `Shoes_01_CLOTH`, is a shoe.
pub(super) fn role(name: &str) -> Option<(Role, String)> {
    let mut told = words(name).into_iter().rev().filter_map(|word| meaning(&word).map(|role| (role, word)));
    let last = told.next()?;
    let before = if is_of(COVERED, &last.1) {
        told.find(|(role, _)| *role == Role::Cloth)
    } else if is_of(PLACES, &last.1) {
        told.next().filter(|(role, word)| *role == Role::Body && !is_of(COVERED, word))
    } else if is_of(FABRICS, &last.1) {
        told.find(|(_, word)| is_of(WORN, word))
    } else {
        None
    };
    Some(before.unwrap_or(last))
}

/// Of the joints that move a part, one that tells that hands and a face are among it; `None` of a garment.
pub(super) fn bare<'a>(joints: &[&'a str]) -> Option<&'a str> {
    let of = |list: &str| joints.iter().copied().find(|joint| words(joint).iter().any(|word| is_of(list, word)));
    let ends = || ENDS.map(of).into_iter().collect::<Option<Vec<_>>>().map(|ends| ends[0]);
    of(BARE).or_else(ends)
}

/// Whether a word tells a part of a body that garments cover too.
pub(super) fn is_covered(word: &str) -> bool {
    is_of(COVERED, word)
}

/// Whether a word tells a garment, and not only its fabric.
pub(super) fn is_garment(word: &str) -> bool {
    meaning(word) == Some(Role::Cloth) && !is_of(FABRICS, word)
}

fn is_of(list: &str, word: &str) -> bool {
    list.split_whitespace().any(|known| known == word)
}

fn meaning(word: &str) -> Option<Role> {
    let lists = [(CLOTH, Role::Cloth), (BODY, Role::Body), (RIGID, Role::Rigid)];
    let exact = lists.iter().find(|(list, _)| is_of(list, word));
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
            ("Drawstring", None),
            ("Hood_Drawstring", Some(Role::Cloth)),
            ("Hood_Head", Some(Role::Body)),
            ("N00_002_03_Tops_01_CLOTH (Instance)", Some(Role::Cloth)),
            ("N00_004_01_Shoes_01_CLOTH (Instance)", Some(Role::Rigid)),
            ("Armor_Cloth", Some(Role::Cloth)),
            ("N00_000_00_Body_00_SKIN (Instance)", Some(Role::Body)),
            ("Chair", None),
            ("Shirt_Body", Some(Role::Cloth)),
            ("skull top", Some(Role::Body)),
            ("Hair_Tops", Some(Role::Body)),
            ("Body_Top", Some(Role::Cloth)),
            ("Hooves", Some(Role::Body)),
            ("Shirt_Button", Some(Role::Rigid)),
            ("", None),
        ] {
            assert_eq!(role(name).map(|r| r.0), is, "{name}");
        }
        assert_eq!(words("Wolf3D_OutfitTop"), ["wolf", "d", "outfit", "top"]);
    }
}
