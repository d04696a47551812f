//! Messages and services of `rcl_interfaces`.

use super::interfaces;
use super::standard::Time;

interfaces! {
    /// A value of one of nine types.
    "rcl_interfaces/ParameterValue" ParameterValue {
        r#type: u8, bool_value: bool, integer_value: i64, double_value: f64, string_value: String, byte_array_value: Vec<u8>,
        bool_array_value: Vec<bool>, integer_array_value: Vec<i64>, double_array_value: Vec<f64>, string_array_value: Vec<String>,
    }
    /// A name and its value.
    "rcl_interfaces/Parameter" Parameter { name: String, value: ParameterValue }
    /// Allowed numbers.
    "rcl_interfaces/FloatingPointRange" FloatingPointRange { from_value: f64, to_value: f64, step: f64 }
    /// Allowed whole numbers.
    "rcl_interfaces/IntegerRange" IntegerRange { from_value: i64, to_value: i64, step: u64 }
    /// What a parameter is.
    "rcl_interfaces/ParameterDescriptor" ParameterDescriptor {
        name: String, r#type: u8, description: String, additional_constraints: String, read_only: bool, dynamic_typing: bool,
        floating_point_range: Vec<FloatingPointRange>, integer_range: Vec<IntegerRange>,
    }
    /// Whether a parameter was set.
    "rcl_interfaces/SetParametersResult" SetParametersResult { successful: bool, reason: String }
    /// Names found.
    "rcl_interfaces/ListParametersResult" ListParametersResult { names: Vec<String>, prefixes: Vec<String> }
    /// Parameters that changed.
    "rcl_interfaces/ParameterEvent" ParameterEvent {
        stamp: Time, node: String, new_parameters: Vec<Parameter>, changed_parameters: Vec<Parameter>, deleted_parameters: Vec<Parameter>,
    }
    /// Names to look for.
    "rcl_interfaces/ListParameters.request" ListParametersRequest { prefixes: Vec<String>, depth: u64 }
    /// Names found.
    "rcl_interfaces/ListParameters.response" ListParametersResponse { result: ListParametersResult }
    /// Names to get, describe or tell the types of.
    "rcl_interfaces/GetParameters.request" NamesRequest { names: Vec<String> }
    /// Their values.
    "rcl_interfaces/GetParameters.response" GetParametersResponse { values: Vec<ParameterValue> }
    /// Their types.
    "rcl_interfaces/GetParameterTypes.response" GetParameterTypesResponse { types: Vec<u8> }
    /// What they are.
    "rcl_interfaces/DescribeParameters.response" DescribeParametersResponse { descriptors: Vec<ParameterDescriptor> }
    /// Values to set.
    "rcl_interfaces/SetParameters.request" SetParametersRequest { parameters: Vec<Parameter> }
    /// Whether they were, one by one.
    "rcl_interfaces/SetParameters.response" SetParametersResponse { results: Vec<SetParametersResult> }
    /// Whether they were, all or none.
    "rcl_interfaces/SetParametersAtomically.response" SetParametersAtomicallyResponse { result: SetParametersResult }
}
