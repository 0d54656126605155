"""FMI 3.0: the description of a co-simulation FMU, and the functions around ``model.c``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from xml.sax.saxutils import quoteattr

PLATFORM: dict[str, Callable[[str], str]] = {
    "Linux": lambda machine: f"{_arch(machine)}-linux",
    "Darwin": lambda machine: f"{_arch(machine)}-darwin",
    "Windows": lambda machine: f"{_arch(machine)}-windows",
}


def _arch(machine: str) -> str:
    return {"AMD64": "x86_64", "arm64": "aarch64", "i686": "x86", "i386": "x86"}.get(machine, machine)


def description(name: str, identifier: str, token: str, variables: Sequence[dict[str, str]]) -> str:
    """``modelDescription.xml``; attributes of the variables are quoted already."""
    units = sorted({v["unit"] for v in variables if "unit" in v})
    rows, outputs = [], []
    for k, variable in enumerate(variables):
        if variable["causality"] == '"output"':
            outputs.append(k)
        attributes = " ".join(f"{key}={value}" for key, value in variable.items())
        initial = ' initial="calculated"' if variable["causality"] == '"output"' else ""
        rows.append(f'    <Float64 valueReference="{k}" {attributes}{initial}/>')
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<fmiModelDescription fmiVersion="3.0" modelName={quoteattr(name)} instantiationToken="{{{token}}}" '
            'generationTool="bench export-model" variableNamingConvention="flat">',
            f'  <CoSimulation modelIdentifier="{identifier}" canHandleVariableCommunicationStepSize="true"/>',
            *(
                ["  <UnitDefinitions>", *(f"    <Unit name={u}/>" for u in units), "  </UnitDefinitions>"]
                if units
                else []
            ),
            "  <ModelVariables>",
            f'    <Float64 name="time" valueReference="{len(variables)}" causality="independent" '
            'variability="continuous" description="time in s"/>',
            *rows,
            "  </ModelVariables>",
            "  <ModelStructure>",
            *(f'    <Output valueReference="{k}"/>' for k in outputs),
            *(f'    <InitialUnknown valueReference="{k}"/>' for k in outputs),
            "  </ModelStructure>",
            "</fmiModelDescription>",
            "",
        ]
    )


_NOT_OFFERED = (
    "GetFloat32", "GetInt8", "GetUInt8", "GetInt16", "GetUInt16", "GetInt32", "GetUInt32", "GetInt64", "GetUInt64",
    "GetBoolean", "GetString", "GetBinary", "GetClock", "SetFloat32", "SetInt8", "SetUInt8", "SetInt16", "SetUInt16",
    "SetInt32", "SetUInt32", "SetInt64", "SetUInt64", "SetBoolean", "SetString", "SetBinary", "SetClock",
    "GetNumberOfVariableDependencies", "GetVariableDependencies", "GetFMUState", "SetFMUState", "FreeFMUState",
    "SerializedFMUStateSize", "SerializeFMUState", "DeserializeFMUState", "GetDirectionalDerivative",
    "GetAdjointDerivative", "EnterConfigurationMode", "ExitConfigurationMode", "GetIntervalDecimal",
    "GetIntervalFraction", "GetShiftDecimal", "GetShiftFraction", "SetIntervalDecimal", "SetIntervalFraction",
    "SetShiftDecimal", "SetShiftFraction", "EvaluateDiscreteStates", "UpdateDiscreteStates",
    "EnterContinuousTimeMode", "CompletedIntegratorStep", "SetTime", "SetContinuousStates",
    "GetContinuousStateDerivatives", "GetEventIndicators", "GetContinuousStates", "GetNominalsOfContinuousStates",
    "GetNumberOfEventIndicators", "GetNumberOfContinuousStates", "EnterStepMode", "EnterEventMode",
    "GetOutputDerivatives", "ActivateModelPartition",
)  # fmt: skip
"""functions of the standard that this FMU declares no capability for; they return an error"""

SOURCE = (
    """/* FMI 3.0 co-simulation around model.c. Outputs are worked out at the end of each step. */
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include "model.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT
#endif
#define ALL (INPUTS + OUTPUTS + PARAMETERS)
enum { OK, WARNING, DISCARD, ERROR };

typedef struct {
    Model model;
    double u[INPUTS + 1], y[OUTPUTS + 1], start, now;
} Instance;

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }
EXPORT int fmi3SetDebugLogging(void *c, bool on, size_t n, const char *const names[])
{
    (void)c; (void)on; (void)n; (void)names;
    return OK;
}

EXPORT void *fmi3InstantiateModelExchange(const char *name, const char *token, const char *resources, bool visible,
                                          bool logging, void *environment, void *log)
{
    (void)name; (void)token; (void)resources; (void)visible; (void)logging; (void)environment; (void)log;
    return NULL;
}

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                         bool logging, bool events, bool early, const unsigned required[], size_t n,
                                         void *environment, void *log, void *update)
{
    (void)name; (void)token; (void)resources; (void)visible; (void)logging; (void)events; (void)early;
    (void)required; (void)n; (void)environment; (void)log; (void)update;
    Instance *own = calloc(1, sizeof(Instance));
    if (own) model_begin(&own->model);
    return own;
}

EXPORT void *fmi3InstantiateScheduledExecution(const char *name, const char *token, const char *resources,
                                               bool visible, bool logging, void *environment, void *log, void *clock,
                                               void *lock, void *unlock)
{
    (void)name; (void)token; (void)resources; (void)visible; (void)logging; (void)environment; (void)log;
    (void)clock; (void)lock; (void)unlock;
    return NULL;
}

EXPORT void fmi3FreeInstance(void *c) { free(c); }

EXPORT int fmi3EnterInitializationMode(void *c, bool given, double tolerance, double start, bool stops, double stop)
{
    (void)given; (void)tolerance; (void)stops; (void)stop;
    ((Instance *)c)->start = ((Instance *)c)->now = start;
    return OK;
}

EXPORT int fmi3ExitInitializationMode(void *c)
{
    Instance *own = c;
    model_step(&own->model, own->start, own->u, own->y);
    return OK;
}

EXPORT int fmi3Terminate(void *c) { (void)c; return OK; }

EXPORT int fmi3Reset(void *c)
{
    memset(c, 0, sizeof(Instance));
    model_begin(&((Instance *)c)->model);
    return OK;
}

EXPORT int fmi3GetFloat64(void *c, const unsigned vr[], size_t n, double value[], size_t values)
{
    Instance *own = c;
    if (values != n) return ERROR;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] > ALL) return ERROR;
        value[i] = vr[i] == ALL ? own->now : vr[i] < INPUTS ? own->u[vr[i]]
            : vr[i] < INPUTS + OUTPUTS ? own->y[vr[i] - INPUTS] : own->model.p[vr[i] - INPUTS - OUTPUTS];
    }
    return OK;
}

EXPORT int fmi3SetFloat64(void *c, const unsigned vr[], size_t n, const double value[], size_t values)
{
    Instance *own = c;
    if (values != n) return ERROR;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] < INPUTS) own->u[vr[i]] = value[i];
        else if (vr[i] >= INPUTS + OUTPUTS && vr[i] < ALL) own->model.p[vr[i] - INPUTS - OUTPUTS] = value[i];
        else return ERROR;
    }
    return OK;
}

EXPORT int fmi3DoStep(void *c, double time, double step, bool keeps, bool *event, bool *ends, bool *early, double *last)
{
    (void)keeps;
    Instance *own = c;
    own->now = time + step;
    model_step(&own->model, own->now, own->u, own->y);
    *event = *ends = *early = false;
    *last = own->now;
    return OK;
}

#define NONE(name) EXPORT int name() { return ERROR; }
"""
    + "\n".join(f"NONE(fmi3{name})" for name in _NOT_OFFERED)
    + "\n"
)
