package org.mrsfi.interop;

import com.google.gson.JsonObject;
import java.io.ByteArrayOutputStream;
import java.io.File;
import java.io.PrintStream;
import java.nio.charset.StandardCharsets;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.stream.Stream;
import org.eclipse.epsilon.emc.emf.EmfModel;
import org.eclipse.epsilon.eol.EolModule;
import org.eclipse.epsilon.eol.IEolModule;
import org.eclipse.epsilon.evl.EvlModule;

/** Runs EOL and EVL as a run configuration of Eclipse does: one EMF model a file, by its path. */
final class Configuration {

    private Configuration() {}

    /**
     * Runs one program over models that it may change, and stores them.
     *
     * @param request paths under "metamodels", "models" (each a model by itself) and "program"
     * @return what the program printed and what it was warned of, line by line; and what is
     *     unsatisfied, if it is one of constraints
     */
    static Object run(JsonObject request) throws Exception {
        File program = new File(request.get("program").getAsString());
        boolean isOfConstraints = program.getName().endsWith(".evl");
        IEolModule module = isOfConstraints ? new EvlModule() : new EolModule();
        ByteArrayOutputStream printed = new ByteArrayOutputStream();
        ByteArrayOutputStream warned = new ByteArrayOutputStream();
        Map<String, Object> answer = new LinkedHashMap<>();
        try {
            Programs.parse(module, program);
            module.getContext().setOutputStream(stream(printed));
            module.getContext().setWarningStream(stream(warned));
            for (String file : Models.paths(request, "models")) {
                module.getContext().getModelRepository().addModel(model(request, file));
            }
            module.execute();
            if (module instanceof EvlModule constraints) {
                answer.put(
                        "unsatisfied",
                        constraints.getContext().getUnsatisfiedConstraints().stream()
                                .map(Validation::description)
                                .toList());
            }
        } finally {
            module.getContext().getModelRepository().dispose();
        }
        answer.put("printed", lines(printed).toList());
        answer.put("warned", lines(warned).toList());
        return answer;
    }

    /** Returns a file as a model that is stored when it is closed. */
    private static EmfModel model(JsonObject request, String file) throws Exception {
        EmfModel model = new EmfModel();
        model.setName(new File(file).getName().replace(".xmi", ""));
        model.setModelFile(file);
        model.setMetamodelFiles(Models.paths(request, "metamodels"));
        model.setExpand(true);
        model.setReadOnLoad(true);
        model.setStoredOnDisposal(true);
        model.load();
        return model;
    }

    private static PrintStream stream(ByteArrayOutputStream lines) {
        return new PrintStream(lines, true, StandardCharsets.UTF_8);
    }

    private static Stream<String> lines(ByteArrayOutputStream printed) {
        return printed.toString(StandardCharsets.UTF_8).lines();
    }
}
