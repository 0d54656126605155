"""FMI 2.0: the description of a co-simulation FMU, and the functions around ``model.c``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from xml.sax.saxutils import quoteattr

PLATFORM: dict[str, Callable[[str], str]] = {
    "Linux": lambda machine: "linux64" if machine.endswith("64") else "linux32",
    "Darwin": lambda _machine: "darwin64",
    "Windows": lambda machine: "win64" if machine.endswith("64") else "win32",
}


def description(name: str, identifier: str, token: str, variables: Sequence[dict[str, str]]) -> str:
    """``modelDescription.xml``; attributes of the variables are quoted already."""
    units = sorted({v["unit"] for v in variables if "unit" in v})
    rows, outputs = [], []
    for k, variable in enumerate(variables):
        real = {key: variable[key] for key in ("unit", "start") if key in variable}
        rest = {key: value for key, value in variable.items() if key not in real}
        if variable["causality"] == '"output"':
            outputs.append(k + 1)
        attributes = " ".join(f"{key}={value}" for key, value in rest.items())
        inner = " ".join(f"{key}={value}" for key, value in real.items())
        initial = ' initial="calculated"' if variable["causality"] == '"output"' else ""
        rows.append(f'    <ScalarVariable valueReference="{k}" {attributes}{initial}><Real {inner}/></ScalarVariable>')
    unknowns = [f'      <Unknown index="{k}"/>' for k in outputs]
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<fmiModelDescription fmiVersion="2.0" modelName={quoteattr(name)} guid="{{{token}}}" '
            'generationTool="bench export-model" variableNamingConvention="flat" numberOfEventIndicators="0">',
            f'  <CoSimulation modelIdentifier="{identifier}" canHandleVariableCommunicationStepSize="true" '
            'canBeInstantiatedOnlyOncePerProcess="false" canNotUseMemoryManagementFunctions="true"/>',
            *(
                ["  <UnitDefinitions>", *(f"    <Unit name={u}/>" for u in units), "  </UnitDefinitions>"]
                if units
                else []
            ),
            "  <ModelVariables>",
            *rows,
            "  </ModelVariables>",
            "  <ModelStructure>",
            "    <Outputs>",
            *unknowns,
            "    </Outputs>",
            "    <InitialUnknowns>",
            *unknowns,
            "    </InitialUnknowns>",
            "  </ModelStructure>",
            "</fmiModelDescription>",
            "",
        ]
    )


SOURCE = """/* FMI 2.0 co-simulation around model.c. Outputs are worked out at the end of each step. */
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
    double u[INPUTS + 1], y[OUTPUTS + 1], start;
} Instance;

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const names[])
{
    (void)c; (void)on; (void)n; (void)names;
    return OK;
}

EXPORT void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources,
                             const void *callbacks, int visible, int logging)
{
    (void)name; (void)guid; (void)resources; (void)callbacks; (void)visible; (void)logging;
    if (kind != 1) return NULL; /* co-simulation only */
    Instance *own = calloc(1, sizeof(Instance));
    if (own) model_begin(&own->model);
    return own;
}

EXPORT void fmi2FreeInstance(void *c) { free(c); }

EXPORT int fmi2SetupExperiment(void *c, int given, double tolerance, double start, int stops, double stop)
{
    (void)given; (void)tolerance; (void)stops; (void)stop;
    ((Instance *)c)->start = start;
    return OK;
}

EXPORT int fmi2EnterInitializationMode(void *c) { (void)c; return OK; }

EXPORT int fmi2ExitInitializationMode(void *c)
{
    Instance *own = c;
    model_step(&own->model, own->start, own->u, own->y);
    return OK;
}

EXPORT int fmi2Terminate(void *c) { (void)c; return OK; }

EXPORT int fmi2Reset(void *c)
{
    memset(c, 0, sizeof(Instance));
    model_begin(&((Instance *)c)->model);
    return OK;
}

EXPORT int fmi2GetReal(void *c, const unsigned vr[], size_t n, double value[])
{
    Instance *own = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= ALL) return ERROR;
        value[i] = vr[i] < INPUTS ? own->u[vr[i]]
            : vr[i] < INPUTS + OUTPUTS ? own->y[vr[i] - INPUTS] : own->model.p[vr[i] - INPUTS - OUTPUTS];
    }
    return OK;
}

EXPORT int fmi2SetReal(void *c, const unsigned vr[], size_t n, const double value[])
{
    Instance *own = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] < INPUTS) own->u[vr[i]] = value[i];
        else if (vr[i] >= INPUTS + OUTPUTS && vr[i] < ALL) own->model.p[vr[i] - INPUTS - OUTPUTS] = value[i];
        else return ERROR;
    }
    return OK;
}

EXPORT int fmi2DoStep(void *c, double time, double step, int keeps)
{
    (void)keeps;
    Instance *own = c;
    model_step(&own->model, time + step, own->u, own->y);
    return OK;
}

#define NONE(name, ...) EXPORT int name(__VA_ARGS__) { return ERROR; }
NONE(fmi2GetInteger, void *c, const unsigned v[], size_t n, int x[])
NONE(fmi2GetBoolean, void *c, const unsigned v[], size_t n, int x[])
NONE(fmi2GetString, void *c, const unsigned v[], size_t n, const char *x[])
NONE(fmi2SetInteger, void *c, const unsigned v[], size_t n, const int x[])
NONE(fmi2SetBoolean, void *c, const unsigned v[], size_t n, const int x[])
NONE(fmi2SetString, void *c, const unsigned v[], size_t n, const char *const x[])
NONE(fmi2GetFMUstate, void *c, void **s)
NONE(fmi2SetFMUstate, void *c, void *s)
NONE(fmi2FreeFMUstate, void *c, void **s)
NONE(fmi2SerializedFMUstateSize, void *c, void *s, size_t *n)
NONE(fmi2SerializeFMUstate, void *c, void *s, char x[], size_t n)
NONE(fmi2DeSerializeFMUstate, void *c, const char x[], size_t n, void **s)
NONE(fmi2GetDirectionalDerivative, void *c, const unsigned u[], size_t n, const unsigned k[], size_t m,
     const double d[], double x[])
NONE(fmi2SetRealInputDerivatives, void *c, const unsigned v[], size_t n, const int o[], const double x[])
NONE(fmi2GetRealOutputDerivatives, void *c, const unsigned v[], size_t n, const int o[], double x[])
NONE(fmi2CancelStep, void *c)
NONE(fmi2GetStatus, void *c, int k, int *x)
NONE(fmi2GetRealStatus, void *c, int k, double *x)
NONE(fmi2GetIntegerStatus, void *c, int k, int *x)
NONE(fmi2GetBooleanStatus, void *c, int k, int *x)
NONE(fmi2GetStringStatus, void *c, int k, const char **x)
"""
