package org.mrsfi.interop;

import com.google.gson.JsonArray;
import com.google.gson.JsonElement;
import com.google.gson.JsonObject;
import java.io.File;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import org.eclipse.emf.common.util.WrappedException;
import org.eclipse.emf.ecore.EObject;
import org.eclipse.emf.ecore.util.EcoreUtil;
import org.eclipse.epsilon.emc.emf.InMemoryEmfModel;
import org.eclipse.epsilon.eol.exceptions.EolRuntimeException;
import org.eclipse.epsilon.evl.EvlModule;
import org.eclipse.epsilon.evl.execute.FixInstance;
import org.eclipse.epsilon.evl.execute.UnsatisfiedConstraint;

/** Runs EVL constraints over models. */
final class Validation {

    private Validation() {}

    /**
     * Checks every model of a request.
     *
     * @param request paths under "metamodels" and "evl"; lists of files that belong together
     *     under "models"
     * @return what EMF has against each model and, if it can be loaded at all, its unsatisfied
     *     constraints, in the order of the request
     */
    static Object validate(JsonObject request) throws Exception {
        Models models = new Models(request);
        List<String> programs = Models.paths(request, "evl");
        List<Object> answers = new ArrayList<>();
        for (JsonElement entry : request.getAsJsonArray("models")) {
            List<String> files = new ArrayList<>();
            for (JsonElement file : (JsonArray) entry) {
                if (!file.isJsonNull()) {
                    files.add(file.getAsString());
                }
            }
            answers.add(validate(models, files, programs));
        }
        return Map.of("models", answers);
    }

    private static Map<String, Object> validate(
            Models models, List<String> files, List<String> programs) throws Exception {
        List<String> errors = new ArrayList<>();
        List<Object> found = new ArrayList<>();
        try {
            for (String file : files) {
                errors.addAll(Saving.problems(models.load(file)));
            }
            found.addAll(unsatisfied(models, files, programs));
        } catch (WrappedException problem) {
            errors.add("load: " + problem.getCause().getMessage());
        }
        return Map.of("models", files, "errors", errors, "unsatisfied", found);
    }

    private static List<Object> unsatisfied(
            Models models, List<String> files, List<String> programs) throws Exception {
        List<Object> found = new ArrayList<>();
        for (String program : programs) {
            InMemoryEmfModel model = Programs.model(models, files);
            EvlModule module = new EvlModule();
            try {
                Programs.parse(module, new File(program));
                module.getContext().getModelRepository().addModel(model);
                for (UnsatisfiedConstraint unsatisfied : module.execute()) {
                    found.add(description(unsatisfied));
                }
            } finally {
                module.getContext().getModelRepository().dispose();
            }
        }
        return found;
    }

    private static Map<String, Object> description(UnsatisfiedConstraint unsatisfied) {
        EObject element = (EObject) unsatisfied.getInstance();
        Map<String, Object> answer = new LinkedHashMap<>();
        answer.put("constraint", unsatisfied.getConstraint().getName());
        answer.put("severity", unsatisfied.getConstraint().isCritique() ? "warning" : "error");
        answer.put("class", element.eClass().getName());
        answer.put("id", EcoreUtil.getID(element));
        answer.put("path", Models.path(element));
        answer.put("file", element.eResource().getURI().toFileString());
        answer.put("message", unsatisfied.getMessage());
        answer.put("fixes", titles(unsatisfied));
        return answer;
    }

    private static List<String> titles(UnsatisfiedConstraint unsatisfied) {
        List<String> titles = new ArrayList<>();
        for (FixInstance fix : unsatisfied.getFixes()) {
            try {
                titles.add(fix.getTitle());
            } catch (EolRuntimeException problem) {
                throw new IllegalStateException(problem);
            }
        }
        return titles;
    }
}
