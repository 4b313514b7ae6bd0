use super::*;

fn names(plan: &Plan) -> Vec<&str> {
    plan.fields.iter().map(|(name, _)| &**name).collect()
}

#[test]
fn constants_defaults_and_comments_are_no_fields() {
    let text = "uint8 MASK=0xff # hexadecimal\nstring NAME = \"a # b\"\nint32 n 7\n\
                string quote \"\nfloat64[<=3] list [1.0, 2.0]  # why\n\nbool last";
    let plan = Plan::new(Dialect::Ros2, "p/msg/T", text.as_bytes()).unwrap();
    assert_eq!(names(&plan), ["n", "quote", "list", "last"]);
    assert_eq!(plan.least_bytes, 4 + 4 + 4 + 1);
}

#[test]
fn a_quote_that_stands_alone_is_no_end() {
    for text in [
        "string=\"",
        "string='",
        "===\"",
        "MSG: string = \"",
        "string a\nstring=\" b",
    ] {
        let _ = Plan::new(Dialect::Ros2, "p/msg/T", text.as_bytes());
        let _ = Plan::new(Dialect::Ros1, "p/T", text.as_bytes());
    }
}

#[test]
fn types_of_the_own_package_need_no_prefix() {
    let text = "Inner[2] a\nother/Thing b\n===\nMSG: p/Inner\nfloat64 x\n===\n\
                MSG: other/msg/Thing\nInner c\n===\nMSG: other/Inner\nuint8 y";
    let plan = Plan::new(Dialect::Ros2, "p/msg/T", text.as_bytes()).unwrap();
    assert_eq!(plan.least_bytes, 17);
}

#[test]
fn ros_1_has_times_and_bare_headers() {
    let text = "Header header\ntime t\nduration[] d\n===\nMSG: std_msgs/Header\nuint32 seq\n\
                time stamp\nstring frame_id";
    let plan = Plan::new(Dialect::Ros1, "p/T", text.as_bytes()).unwrap();
    assert_eq!(plan.least_bytes, (4 + 8 + 4) + 8 + 4);
    let ros2 = Plan::new(Dialect::Ros2, "p/msg/T", text.as_bytes());
    assert_eq!(
        ros2.unwrap_err(),
        SchemaError::UnknownType("p/Header".into())
    );
}

#[test]
fn types_of_constants_or_of_nothing_are_types() {
    let text = "Empty e\nKind k\n===\nMSG: p/Empty\n===\nMSG: p/Kind\nuint8 A=1\nuint8 B=2";
    assert!(Plan::new(Dialect::Ros2, "p/msg/T", text.as_bytes()).is_ok());
}

#[test]
fn a_type_that_contains_itself_is_refused() {
    let text = "Loop l\n===\nMSG: p/Loop\nLoop l";
    let refused = Plan::new(Dialect::Ros2, "p/msg/T", text.as_bytes());
    assert_eq!(refused.unwrap_err(), SchemaError::TooDeep);
}
